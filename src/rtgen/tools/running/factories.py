"""Finds the factories of component types: in the project first, then in installed packages."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from importlib import import_module, invalidate_caches
from pathlib import Path
from types import ModuleType

from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.kit import plugins
from rtgen.compiler.project import Project, output, shown
from rtgen.runtime import Component
from rtgen.runtime.failures import ends_run
from rtgen.runtime.stack_frames import is_rtgens, is_users
from rtgen.runtime.system.watchdog import calling

GROUP = "rtgen.components"

Factory = Callable[[str], Component]


class Factories:
    """The factories of component types by name.

    Precedence: `[components]` of rtgen.toml, the manifest of the project's output folder,
    installed entry points.
    """

    def __init__(self, project: Project) -> None:
        generated = output.component_types(project.output)
        installed = {e.name: e.value for e in plugins.announced(GROUP)}
        self._targets: dict[str, str] = {
            **installed,
            **generated.factories,
            **dict(project.components),
        }
        self.defined = {*generated.factories} if project.sources else set()
        """Types with a definition in the project, by which the judge knows their ports."""
        self.foreign: dict[str, str] = {
            name: language
            for name, language in generated.languages.items()
            if name not in dict(project.components) and name not in installed
        }
        """Languages of the types that other programs run, according to their profiles."""
        self._folders = project.import_folders
        for folder in reversed(self._folders):
            if folder.is_dir() and str(folder) not in sys.path:
                sys.path.insert(0, str(folder))

    def forget(self) -> None:
        """Forget the modules of the project, so that they are imported again."""
        folders = [folder.resolve() for folder in self._folders]
        for name, module in [*sys.modules.items()]:
            file = getattr(module, "__file__", None)
            if file and any(Path(file).is_relative_to(each) for each in folders):
                del sys.modules[name]
        invalidate_caches()

    @property
    def types(self) -> Mapping[str, str]:
        """Every known type with its `module:attribute`."""
        return self._targets

    def hint(self, type_name: str) -> str:
        """Return a hint for an unknown type."""
        close = get_close_matches(type_name, self._targets, n=1)
        if close:
            return f"did you mean {close[0]!r}?"
        return (
            "run rtgen generate if a definition has it; else name its factory in [components]"
            " of rtgen.toml, or install its package"
        )

    def __contains__(self, type_name: str) -> bool:
        return type_name in self._targets

    def __getitem__(self, type_name: str) -> Factory:
        """Return the factory of a known type.

        Raises FactoryImportError if its module cannot be imported, ToolError if it is not callable.
        """
        target = self._targets[type_name]
        module, _, attribute = target.partition(":")
        try:
            factory: object = calling(type_name, "import", import_module, module)
            for part in attribute.split("."):
                factory = getattr(factory, part)
        except BaseException as error:
            if ends_run(error):
                raise
            message = f"{target}, the factory of {type_name}, cannot be imported"
            hint = self._hidden(module) or self._advice(error, module)
            is_users = self._is_users(error, module)
            if self._is_missing(error, type_name):
                hint = "rtgen generate creates the skeleton of its behaviour"
                is_users = True
            raise FactoryImportError(message, hint, is_users=is_users) from error
        if not callable(factory):
            raise ToolError(f"the factory {target} of {type_name} cannot be called")
        return factory

    def _hidden(self, module: str) -> str | None:
        """Return a hint about a module of the project that another one of its name hides."""
        name = module.partition(".")[0]
        loaded = sys.modules.get(name)
        if loaded is None:
            return None
        place = getattr(loaded, "__file__", None)
        for folder in self._folders:
            for file in (folder / f"{name}.py", folder / name / "__init__.py"):
                if file.is_file() and (place is None or not file.samefile(place)):
                    other = f"{place} is" if place else "Python has one"
                    return f"{shown(file)} is hidden: {other} called {name}, too"
        return None

    def _is_missing(self, error: BaseException, type_name: str) -> bool:
        """Return whether the project has the component, and no module with its behaviour."""
        module = self._targets[type_name].partition(":")[0]
        return (
            isinstance(error, ModuleNotFoundError)
            and type_name in self.defined
            and f"{module}.".startswith(f"{error.name}.")
        )

    def _advice(self, error: BaseException, module: str) -> str | None:
        """Return a hint for a failed import."""
        match error:
            case ModuleNotFoundError(name=str(missing)):
                if module == missing or module.startswith(f"{missing}."):
                    return "is its package installed, and `rtgen generate` done?"
                name = missing.partition(".")[0]
                near = self._own(name)
                if near is None:
                    return f"is {name} installed in this environment?"
                return (
                    "is `rtgen generate` done?"
                    if near == name
                    else f"did you mean {near}?"
                )
            case AttributeError(name=str(name), obj=ModuleType() as holder):
                close = get_close_matches(name, vars(holder), n=1)
                return f"did you mean {close[0]}?" if close else None
        return None

    def _is_users(self, error: BaseException, module: str) -> bool:
        """Return whether a failed import is a mistake in the user's own files."""
        match error:
            case ModuleNotFoundError(name=str(missing)) if missing != module:
                return self._own(missing.partition(".")[0]) is not None
            case SyntaxError(filename=str(file)):
                return is_users(file)
        frames = [
            frame.filename
            for frame in traceback.extract_tb(error.__traceback__)
            if not (is_rtgens(frame.filename) or frame.filename.startswith("<"))
        ]
        if isinstance(error, ImportError):
            frames = frames[-1:]  # an import within an installed package that fails
        holder = getattr(error, "obj", None)  # which lacks the factory
        frames.append(getattr(holder, "__file__", None) or "<")
        return any(map(is_users, frames))

    def _own(self, name: str) -> str | None:
        """Return the name of a module or package of the project, or the most similar one."""
        own = {
            path.stem
            for folder in self._folders
            if folder.is_dir()
            for path in folder.iterdir()
            if path.suffix == ".py" or path.is_dir()
        }
        close = get_close_matches(name, sorted(own), n=1, cutoff=0.8)
        return name if name in own else close[0] if close else None


class FactoryImportError(ToolError):
    """The module of a component cannot be imported; its cause is the original exception.

    `is_users`: the mistake is in the user's own files, not in the environment.
    """

    def __init__(self, message: str, hint: str | None, *, is_users: bool) -> None:
        super().__init__(message, hint=hint)
        self.is_users = is_users
