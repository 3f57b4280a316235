"""Classes in place of what a drafted robot does not have, as text: anything, and modules that are not installed."""

ANYTHING = '''

class AnythingsClass(type):
    """A class that has each attribute as well: `Colour.RED`."""

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return Anything()


class Anything(metaclass=AnythingsClass):
    """In place of what is not known: it has each attribute, can be called, and says nothing."""

    def __getattr__(self, name: str) -> Anything:
        if name.startswith("__"):
            raise AttributeError(name)
        return Anything()

    def __init__(self, *_: Any, **named: Any) -> None:
        self.__dict__.update(named)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Anything; a decorator leaves a function as it is."""
        is_decorator = len(arguments) == 1 and not named and isinstance(arguments[0], FunctionType)
        return arguments[0] if is_decorator else Anything()

    def __await__(self) -> Iterator[Any]:
        return iter(())

    def __getitem__(self, _: Any) -> Anything:
        return Anything()

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        return None

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Any:
        raise StopAsyncIteration

    def __len__(self) -> int:
        return 0

    def __bool__(self) -> bool:
        return False

    def __float__(self) -> float:
        return 0.0

    def __int__(self) -> int:
        return 0

    def __index__(self) -> int:
        return 0

    def _number(self, *_: Any) -> float:
        return 0.0

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _number
    __truediv__ = __neg__ = __abs__ = __or__ = __and__ = _number

    def __lt__(self, other: Any) -> bool:
        return bool(other > 0)

    def __gt__(self, other: Any) -> bool:
        return bool(other < 0)

    def __le__(self, other: Any) -> bool:
        return bool(other >= 0)

    def __ge__(self, other: Any) -> bool:
        return bool(other <= 0)
'''

MISSING = '''

class Missing(ModuleType):
    """In place of a module that is not installed here."""

    __path__: list[str] = []  # so that it has submodules

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return type(name, (Anything,), {}) if name[:1].isupper() and not name.isupper() else Anything()


class MissingModules(MetaPathFinder, Loader):
    """Finds the modules that are not installed, and hands out stand-ins."""

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """For these modules only."""
        return ModuleSpec(fullname, self, is_package=True) if fullname.partition(".")[0] in MISSING else None

    def create_module(self, spec: ModuleSpec) -> Missing:
        """A stand-in."""
        return Missing(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """There is nothing to execute."""


def stand_in_for_missing_modules() -> None:
    """Let the code be imported, without what is not installed."""
    if not any(isinstance(finder, MissingModules) for finder in sys.meta_path):
        sys.meta_path.insert(0, MissingModules())
'''
