"""Runs launch files with the installed `launch` and `launch_ros`, in virtual time.

`Ros2Overlay` calls `find` for each declared `Launch`, and runs `launch_body` in the `Process` that `launch_process`
makes. The launch system is a program of asyncio, whose event loop here waits in the kernel. Only its functions that
start processes of the operating system are replaced; see `launch_processes`.
"""

from __future__ import annotations

import asyncio
import importlib.machinery
import importlib.util
import logging
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from pytest_hricdv._base.error_text import causes, error_text
from pytest_hricdv._base.message import InputError, nearest
from pytest_hricdv.declarations.ros2 import Launch, LaunchError, MissingExecutableError
from pytest_hricdv.extra.ros2.executables import Executables, ForeignExecutableError
from pytest_hricdv.extra.ros2.launch_processes import NoSignals, Processes, Transport, connect_protocol
from pytest_hricdv.extra.ros2.packages import SourcePackage, add_to_index, find_share, packages_around
from pytest_hricdv.extra.ros2.processes import Process
from pytest_hricdv.run import TestbenchError
from pytest_hricdv.runtime.virtual.event_loop import VirtualEventLoop

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

PACKAGES = ("launch", "launch_ros", "launch_xml", "launch_yaml", "osrf_pycommon")
"""The packages of the launch system, which run in virtual time."""

_INSTANT_S = 1e-6
"""The resolution of virtual time (s)."""


@dataclass(frozen=True)
class LaunchFile:
    """A launch file that was found, with the packages in source form around it, by name."""

    launch: Launch
    path: Path
    sources: Mapping[str, SourcePackage]

    @cached_property
    def executables(self) -> Executables:
        """Finds the code of the executables that the file starts."""
        return Executables(self.launch, self.sources)


def find(launch: Launch) -> LaunchFile:
    """Find a launch file, and the packages around it.

    Raises:
        LaunchError: the launch system is not installed, or there is no such file or package.
    """
    for name in ("launch", "launch_ros"):
        if importlib.util.find_spec(name) is None:
            raise MissingExecutableError(
                f"{launch}: the package {name!r} of ROS 2, which reads launch files, cannot be imported; source a "
                f"distribution, or install it from its sources: pip install "
                f'"{name} @ git+https://github.com/ros2/{name}@kilted#subdirectory={name}"'
            )
        _require_launch_system(launch, name)
    workspace = [Path(folder) for folder in launch.workspace]
    missing = next((folder for folder in workspace if not folder.is_dir()), None)
    if missing is not None:
        raise LaunchError(f"{launch}: workspace: {missing.absolute()} is not a folder")
    if not launch.package:
        path = Path(launch.file)
        if not path.is_file():
            raise LaunchError(f"{launch}: there is no file {path.absolute()}; paths begin where pytest was started")
        return LaunchFile(launch, path.absolute(), packages_around(path, workspace))
    sources = packages_around(Path("pytest.ini"), [*workspace, Path()])
    return LaunchFile(launch, _in_package(launch, sources), sources)


_PARTS = {"launch": "launch_service", "launch_ros": "actions"}
"""A module that the package of this name has if it is that of ROS 2."""


def _require_launch_system(launch: Launch, name: str) -> None:
    """Refuse another package of the same name: PyPI has a `launch` that is not of ROS 2."""
    spec = importlib.util.find_spec(name)
    folders = [] if spec is None else list(spec.submodule_search_locations or [])
    if importlib.machinery.PathFinder.find_spec(f"{name}.{_PARTS[name]}", folders) is None:
        where = spec.origin if spec is not None and spec.origin else ", ".join(folders)
        raise MissingExecutableError(
            f"{launch}: the package {name!r} in {where} is not that of ROS 2, but another one of this name, such as "
            f"PyPI has; remove it, pip uninstall {name}, and source a distribution, or install ROS 2's: pip install "
            f'"{name} @ git+https://github.com/ros2/{name}@kilted#subdirectory={name}"'
        )


def _in_package(launch: Launch, sources: Mapping[str, SourcePackage]) -> Path:
    share = sources[launch.package].folder if launch.package in sources else find_share(launch.package)
    if share is None:
        raise MissingExecutableError(
            f"{launch}: there is no package {launch.package!r}, neither installed nor below {Path().absolute()}"
            f"{nearest(launch.package, list(sources))}; name the folder with its sources: Launch(..., workspace=[...])"
        )
    if (share / launch.file).is_file():
        return share / launch.file
    files = sorted(path for path in share.rglob(Path(launch.file).name) if path.is_file())
    if len(files) != 1:
        others = sorted({path.name for path in share.rglob("*launch*") if path.is_file()})
        problem = f"has several: {', '.join(map(str, files))}" if files else f"has none; there are {', '.join(others)}"
        raise LaunchError(f"{launch}: package {launch.package!r}, in {share}, {problem}")
    return files[0]


def check_arguments(file: LaunchFile, description: Any) -> None:
    """Refuse arguments that a launch file does not declare, unless it has functions that may use them.

    Raises:
        LaunchError: an argument is missing, or is not declared; the message has those that are.
    """
    listed = description.get_launch_arguments_with_include_launch_description_actions()
    declared = {argument.name: (argument, inclusions) for argument, inclusions in listed}
    names = f"it declares {', '.join(declared) or 'none'}"
    arguments = file.launch.arguments
    unknown = [name for name in arguments if name not in declared]
    # An undeclared argument may still be read, by a configuration with its own default.
    if unknown and not _may_use(description.entities, unknown[0]):
        raise LaunchError(f"{file.launch}: no argument {unknown[0]!r}{nearest(unknown[0], list(declared))}; {names}")
    for name, (argument, inclusions) in declared.items():
        is_needed = argument.default_value is None and not argument._conditionally_included
        if is_needed and not inclusions and name not in arguments:  # the launch system looks after inclusions
            raise LaunchError(
                f"{file.launch}: argument {name!r} has no default, and no value; give it one: "
                f'Launch(..., arguments={{"{name}": ...}}); {names}'
            )


def _may_use(entities: Any, name: str) -> bool:
    """Whether entities contain functions, inclusions that depend on values, or a configuration of this name."""
    for entity in entities:
        kind = type(entity).__name__
        if kind in ("OpaqueFunction", "OpaqueCoroutine"):
            return True
        if kind == "IncludeLaunchDescription":
            source = entity.launch_description_source
            if source.try_get_launch_description_without_context() is None:
                return True
        if _names(vars(entity).values(), name, 0) or _may_use(entity.describe_sub_entities(), name):
            return True
        if any(_may_use(below, name) for _, below in entity.describe_conditional_sub_entities()):
            return True
    return False


def _names(values: Any, name: str, depth: int) -> bool:
    for value in values:
        if type(value).__name__ == "LaunchConfiguration":
            texts = getattr(value, "variable_name", ())
            if "".join(getattr(text, "text", "") for text in texts) == name:
                return True
        if depth < 8:  # a list of parameters has 4 levels
            inner: Any = ()
            if isinstance(value, Mapping):
                inner = [*value.keys(), *value.values()]
            elif isinstance(value, list | tuple):
                inner = value
            elif type(value).__module__.partition(".")[0] in PACKAGES and hasattr(value, "__dict__"):
                inner = vars(value).values()
            if _names(inner, name, depth + 1):
                return True
    return False


def launch_body(file: LaunchFile, processes: Processes) -> Callable[[], None]:
    """The body of the process of the launch system, for a node of the kernel.

    It ends when all that it has started has ended. What is wrong with a launch file ends the run with a LaunchError.
    """

    def body() -> None:
        errors: list[BaseException] = []
        with ExitStack() as stack:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hri-launch-")))
            loop = VirtualEventLoop()
            stack.callback(loop.close)
            # Not `asyncio.run`, which cancels tasks at its end: a run may end at any point.
            try:
                stack.enter_context(_prepare(file, processes, folder, loop, errors))
                loop.run_until_complete(_run(file, folder, errors))
            except Exception as error:
                errors.append(error)
                loop.abandon_tasks()
        if errors:
            raise TestbenchError(f"run.ros2: {_all_of(file, errors)}") from None

    return body


def launch_process(processes: Processes, file: LaunchFile) -> Process:
    """The process in which a launch file is run: what it sets in the environment is seen by what it starts."""
    return Process(processes.kernel, processes.variables, ["ros2 launch", str(file.path)], "launch", dict(os.environ))


def _all_of(file: LaunchFile, errors: Sequence[BaseException]) -> str:
    """The first error, and the names of other executables that are refused."""
    first = _as_input_error(file, errors[0])
    others = dict.fromkeys(error.name for error in errors[1:] if isinstance(error, ForeignExecutableError))
    return f"{first}{'; the same of ' if others else ''}{', '.join(others)}"


def _as_input_error(file: LaunchFile, error: BaseException) -> InputError:
    if isinstance(error, InputError):
        return error
    lost = next((cause for cause in causes(error) if type(cause).__name__ == "PackageNotFoundError"), None)
    if lost is not None:
        package = re.search(r"'([^']+)'", str(lost.args[0]))  # "package 'cell' not found, searching: ..."
        return LaunchError(
            f"{file.launch}: there is no package {package[1] if package else lost.args[0]!r}, neither installed nor in "
            "the workspace; name the folder with its sources: Launch(..., workspace=[...])"
        )
    return LaunchError(f"{file.launch}: {error_text(error)}")


async def _run(file: LaunchFile, folder: Path, errors: list[BaseException]) -> None:
    """Run a launch file to its end; what goes wrong is added to `errors`."""
    import launch  # type: ignore[import-not-found, unused-ignore]
    from launch.actions import IncludeLaunchDescription  # type: ignore[import-not-found, unused-ignore]
    from launch.launch_description_sources import (  # type: ignore[import-not-found, unused-ignore]
        AnyLaunchDescriptionSource,
    )

    launch.logging.launch_config.log_dir = str(folder)

    class RecordingService(launch.LaunchService):  # type: ignore[misc, unused-ignore]
        """The launch system, which keeps what it would only log."""

        def _shutdown(self, **options: Any) -> Any:
            error = sys.exc_info()[1]
            if error is not None:
                errors.append(error)
                asyncio.get_running_loop().stop()
            return super()._shutdown(**options)

    arguments = {name: _text(value) for name, value in file.launch.arguments.items()}
    service = RecordingService(argv=[f"{name}:={value}" for name, value in arguments.items()], noninteractive=True)
    launch.logging.launch_config.level = logging.WARNING  # not before: the service sets it
    source = AnyLaunchDescriptionSource(str(file.path))
    description = source.get_launch_description(service.context)
    check_arguments(file, description)
    inclusion = IncludeLaunchDescription(source, launch_arguments=list(arguments.items()))
    service.include_launch_description(launch.LaunchDescription([inclusion]))
    await service.run_async()


def _text(value: Any) -> str:
    """An argument as it is written on the command line of `ros2 launch`."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _says_what_follows(made: Any) -> bool:
    """Whether a launch file restarts a process, or handles its end, in addition to what each action does itself.

    Args:
        made: what makes the protocol of the process: a function of its action, which encloses both.
    """
    enclosed = dict(zip(made.__code__.co_freevars, (cell.cell_contents for cell in made.__closure__), strict=True))
    action, context = enclosed["self"], enclosed["context"]
    if getattr(action, "_ExecuteLocal__respawn", False) or getattr(action, "_ExecuteLocal__on_exit", None):
        return True
    from launch.events.process import ProcessExited  # type: ignore[import-not-found, unused-ignore]

    event = ProcessExited(returncode=1, **{"pid": 0, **enclosed["process_event_args"]})
    matching = [handler for handler in context._event_handlers if handler.matches(event)]
    own = 2  # an action has two handlers of its own: one for `on_exit`, one that writes what is left to be written
    return len(matching) > own


def _end_logs(logging_of_launch: Any) -> None:
    """Close the files that the launch system logs to, and let go of the standard output of this run."""
    for handler in logging_of_launch.launch_config.file_handlers.values():
        handler.close()
    logging_of_launch.reset()


@contextmanager
def _prepare(
    file: LaunchFile, processes: Processes, folder: Path, loop: VirtualEventLoop, errors: list[BaseException]
) -> Iterator[None]:
    """Let the launch system start processes of the run, and know packages that are there as sources."""
    import launch.actions.execute_local  # type: ignore[import-not-found, unused-ignore]
    import launch.launch_service  # type: ignore[import-not-found, unused-ignore]
    import launch_ros.ros_adapters  # type: ignore[import-not-found, unused-ignore]
    import launch_ros.substitutions.executable_in_package as in_package  # type: ignore[import-not-found, unused-ignore]
    from launch.utilities import perform_substitutions  # type: ignore[import-not-found, unused-ignore]

    launch.logging.reset()
    add_to_index(folder, file.sources.values())
    variable = "AMENT_PREFIX_PATH"
    os.environ[variable] = os.pathsep.join(filter(None, [str(folder), os.environ.get(variable, "")]))

    async def start(made: Any, cmd: list[str], cwd: Any, env: Mapping[str, str], **_: Any) -> tuple[Transport, Any]:
        del cwd  # one process of the machine has one working directory
        loop = asyncio.get_running_loop()
        try:
            transport = processes.start(cmd, env)
            transport.is_expected_to_fail = _says_what_follows(made)
        except Exception as error:  # the launch system would log it, and continue
            fail(error)
            transport = Transport(processes.kernel, 0)
        return transport, connect_protocol(loop, made, transport)

    def fail(error: Exception) -> None:
        errors.append(error)
        # Later, so that what else is started at this instant, and refused, is in the same message.
        loop.call_soon_threadsafe(loop.call_later, _INSTANT_S, loop.stop)

    processes.failed = fail

    def perform(self: Any, context: Any) -> str:
        package = perform_substitutions(context, self.package)
        return f"/lib/{package}/{perform_substitutions(context, self.executable)}"

    with ExitStack() as stack:
        stack.callback(_end_logs, launch.logging)
        for place, name, value in (
            (launch.actions.execute_local, "async_execute_process", start),
            (launch.launch_service, "AsyncSafeSignalManager", NoSignals),
            (in_package.ExecutableInPackage, "perform", perform),
            (tempfile, "tempdir", str(folder)),
            # Its node is named after its process, which is another one in each repeat.
            (launch_ros.ros_adapters, "os", SimpleNamespace(getpid=lambda: 1)),
        ):
            stack.callback(partial(setattr, place, name, vars(place)[name]))
            setattr(place, name, value)
        yield
