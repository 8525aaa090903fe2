"""An engine: it compiles, runs or renders generated source of some targets on this machine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from mrm_mtlx.engines.base.program import Capabilities

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base.availability import Availability
    from mrm_mtlx.engines.base.closures import ClosureBench
    from mrm_mtlx.engines.base.program import Program
    from mrm_mtlx.engines.base.scenes import SceneRenderer
    from mrm_mtlx.shadergen import Shader


class Engine(ABC):
    """A compiler, runner or renderer of generated source; the registry has one instance of each.

    Attributes
    ----------
    name
        What reports call it; unique.
    use
        What it does, for `mrm doctor`, such as "compiles Slang".
    targets
        Names of the targets whose source it takes, see `shadergen.TARGETS`; a picture is made of the first.
    capabilities
        What its programs can be asked for.
    bench
        Measures what closures reflect, in a renderer of OSL, whose shaders return no colour; else None.
    scene_renderer
        Renders whole pictures of meshes; else None.
    """

    name: str
    use: str
    targets: tuple[str, ...]
    capabilities: Capabilities = Capabilities()
    bench: ClosureBench | None = None
    scene_renderer: SceneRenderer | None = None

    @abstractmethod
    def availability(self) -> Availability:
        """Say whether it works here: tried, not only found; with the command that adds what is missing.

        It is asked for before each use, so what takes long is to be remembered.
        """

    @abstractmethod
    def compile(self, shader: Shader, images: Mapping[str, NDArray[Any]] | None = None) -> Program:
        """Compile a shader of one of its targets.

        Parameters
        ----------
        shader
            Its sources are taken as they are.
        images
            Pixels, (height, width, channels), row 0 at the top, for uniforms of image files, by variable name; given to
            engines with textures alone. In the place of a missing one is a pixel of the node's default.

        Raises
        ------
        CompileError
            If the compiler refuses the source; with place and message.
        ImagesTooLargeError
            If the images take more memory than is allowed.
        EngineFailure
            If the engine is missing or died.
        """

    def stop(self) -> None:  # noqa: B027 -- most keep none
        """End processes that it keeps for the next request; it starts them again when asked. By default nothing."""
