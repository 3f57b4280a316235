"""Running one concrete test, and the processes in which tests are run."""
