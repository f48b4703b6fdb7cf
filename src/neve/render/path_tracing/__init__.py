"""Pictures by path tracing with Mitsuba 3: snow as a surface or as a volume of light."""
