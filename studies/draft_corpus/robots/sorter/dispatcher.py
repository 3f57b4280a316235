import logging
import queue
import threading

logger = logging.getLogger("sorter.dispatch")


class Dispatcher(threading.Thread):
    """Takes (name, payload) pairs off one queue and calls what was registered for the name."""

    def __init__(self, inbox):
        super().__init__(name="dispatcher", daemon=True)
        self.inbox = inbox
        self._handlers = {}
        self._stop_event = threading.Event()

    def register(self, name, handler):
        self._handlers.setdefault(name, []).append(handler)

    def stop(self):
        self._stop_event.set()
        self.inbox.put(None)
        self.join(timeout=2.0)

    def run(self):
        while not self._stop_event.is_set():
            try:
                item = self.inbox.get(timeout=1.0)
            except queue.Empty:
                continue
            if item is None:
                break
            name, payload = item
            handlers = self._handlers.get(name)
            if not handlers:
                logger.warning("nobody handles %r", name)
                continue
            for handler in handlers:
                try:
                    handler(payload)
                except Exception:
                    logger.exception("handler of %r failed", name)
