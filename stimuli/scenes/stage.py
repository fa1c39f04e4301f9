"""A stage of a plan: what it needs, what it gives, with which settings, at what predicted error and cost."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from tactometry.target import resolve

if TYPE_CHECKING:
    from .demand import Demand

Setting = float | int | str | tuple[float, ...] | tuple[str, ...]


@dataclass(frozen=True)
class Size:
    """How finely a stage works: settings that the tolerated error chooses, the error that is left, and the work.

    `n_operations` is the predicted number of floating-point operations of one run.
    """

    settings: Mapping[str, Setting] = field(default_factory=dict)
    error: float = 0.0
    n_operations: float = 0.0


@dataclass(frozen=True)
class Stage:
    """One step from quantities to a quantity.

    Parameters
    ----------
    name : str
        What the step is, in the words of `tactometry scene --explain`; a key of ``[settings]`` in a scene file.
    needs : tuple of str
        Names of the quantities that it reads. If `gives` is among them the stage changes that quantity; if not, it
        takes the place of whatever gave it before.
    gives : str
        Name of the quantity.
    target : str
        ``module:function``; the function takes the settings by name and returns the callable of the run, which takes
        the needed quantities in their order. It is imported when the plan is bound, and not before.
    settings : mapping
        Numbers and texts that are fixed when the plan is made.
    error : float
        Predicted relative error of what it gives; 0 for an exact stage.
    n_operations : float
        Predicted number of floating-point operations of one run.
    effect : str
        Kind of the effect that brings it; empty for a stage of the surface.
    size : callable, optional
        What is left to say of settings, error and work: asked for once the stage is known to be needed, so that what
        no output needs is neither computed nor refused.
    """

    name: str
    needs: tuple[str, ...]
    gives: str
    target: str
    settings: Mapping[str, Setting] = field(default_factory=dict)
    error: float = 0.0
    n_operations: float = 0.0
    effect: str = ""
    size: "Callable[[Demand], Size] | None" = field(default=None, repr=False, compare=False)

    @property
    def changes(self) -> bool:
        """Whether it changes a quantity, rather than to make it."""
        return self.gives in self.needs

    def sized(self, demand: "Demand") -> "Stage":
        """The stage with all its settings."""
        if self.size is None:
            return self
        size = self.size(demand)
        settings = {**self.settings, **size.settings}
        return replace(self, settings=settings, error=size.error, n_operations=size.n_operations)

    def bind(self) -> Callable[..., Any]:
        """The callable of the run, with the settings in it."""
        call: Callable[..., Any] = resolve(self.target)(**self.settings)
        return call
