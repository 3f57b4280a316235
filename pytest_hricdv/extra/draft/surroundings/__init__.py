"""What surrounds the code: what is called to run it, the devices that it is handed, its waits and effects."""
