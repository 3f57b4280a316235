"""A robot that carries parcels from a loading bay to rooms: asyncio, with the library `transitions`."""
