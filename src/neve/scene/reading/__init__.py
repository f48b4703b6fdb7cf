"""Read scenes from files and presets, change single values, and say in one sentence what is wrong."""
