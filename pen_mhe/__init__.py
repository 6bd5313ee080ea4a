"""How do I use it from outside: command line, readers and writers of recordings."""
