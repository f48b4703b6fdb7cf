"""Files that a page asks for: pictures, films, replays, scenes."""
