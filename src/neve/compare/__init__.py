"""Compare methods: the same scene by each, on the same clock."""
