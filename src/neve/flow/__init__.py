"""Snow that comes and goes while a run goes on, by any method that can add and drop particles."""
