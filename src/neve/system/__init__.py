"""What the operating system gives: the disk, the standard streams, and Ctrl-C."""
