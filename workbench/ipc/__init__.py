"""One way to own a child process and talk to it."""
