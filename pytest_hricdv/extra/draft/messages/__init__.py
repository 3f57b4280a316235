"""What the code says and hears: classes, texts and dicts, by a bus, queues, connections or calls."""
