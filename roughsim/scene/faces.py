"""The faces of a scene: C(q), its lay, and the directions of sliding with results of their own."""

import math
from functools import cached_property
from typing import Any

import numpy as np

from roughsim.scene.bodies import Bodies
from roughsim.scene.numerics import SLIDING
from roughsim.scene.sections import SAME_ANGLE, CounterfaceSection, SurfaceSection
from roughsim.scene.tables import PSD_SCALES, directions_of
from roughsim.surface.directions import DirectedSpectrum, with_lays
from roughsim.surface.power_laws import SelfAffineSpectrum, TabulatedSpectrum
from roughsim.surface.spectrum import Face, SumSpectrum, TruncatedSpectrum
from roughsim.surface.topography.texture import Texture

_DIRECTIONS = (0.0, math.pi / 4, math.pi / 2)  # of a face with a lay, if the scene gives none


class Faces(Bodies):
    """The faces of the bodies of a scene."""

    surface: SurfaceSection

    @cached_property  # .2 ms, a hundred times in a comparison
    def spectrum(self) -> Face | SumSpectrum:
        """Composite C(q) = C₁(q) + C₂(q) of the two uncorrelated faces, m⁴, Persson's convention."""
        faces = self.faces
        if len(faces) == 1:
            return faces[0]
        return faces[0].scaled(2.0) if faces[0] is faces[1] else faces[0] + faces[1]

    @property
    def rms_slope(self) -> float:
        """√⟨|∇h|²⟩ of the faces together, with their lay."""
        return self.spectrum.rms_slope * steeper(self.lay)

    @cached_property  # asked for with each spectrum, and by two faces that slide
    def faces(self) -> tuple[Face, ...]:
        """C(q) of each rough face, m⁴: one or two."""
        directed = self.directed_angle is not None
        face, other = _face_spectrum(self.surface, directed), self.counterface
        if other is None or not (other.like or other.rough):
            return (face,)
        return (face, face if other.like else _face_spectrum(other, directed))

    @property
    def sliding_faces(self) -> tuple[Face, Face | None]:
        """C(q), m⁴, of the resting and of the moving face, None for a flat.

        The only rough face of a scene rests. Of two, the face of [surface] moves with [body].
        """
        return (self.faces[0], None) if len(self.faces) == 1 else (self.faces[1], self.faces[0])

    @property
    def sections_of_faces(self) -> dict[str, SurfaceSection]:
        """The sections that may have a roughness, by their names."""
        counterface = {"counterface": self.counterface} if self.counterface is not None else {}
        return {"surface": self.surface, **counterface}

    @property
    def sections_of_rough_faces(self) -> dict[str, SurfaceSection]:
        """The sections with a roughness of their own, by their names."""
        faces = self.sections_of_faces.items()
        return {name: face for name, face in faces if face.rough}

    @property
    def scanned(self) -> bool:
        """Whether a C(q) was measured on maps, and has an error of its own."""
        return bool(self.scanned_faces)

    @property
    def scanned_faces(self) -> dict[str, SurfaceSection]:
        """The sections of faces whose C(q) was measured on maps, by their names."""
        faces = self.sections_of_faces.items()
        return {name: face for name, face in faces if face.psd_source == "scan"}

    @property
    def textures(self) -> dict[str, tuple[Texture, ...]]:
        """The textures of the maps of each face by its section; no entry for a C(q) without maps."""
        faces = self.sections_of_faces.items()
        return {name: face.psd_texture for name, face in faces if face.psd_texture}

    @property
    def grooves(self) -> tuple[float, float]:
        """The lay of the rough faces, and the direction of its grooves, radians from x; (1, 0) of isotropic ones.

        It is (1, 0) as well of faces whose lays differ: these have square pixels.
        """
        return (1.0, 0.0) if self.lays_differ else self.surface.grooves

    @cached_property  # asked for a hundred times in each table of a run
    def lays_differ(self) -> bool:
        """Whether the rough faces have two lays, or only one of them has one."""
        first, *others = (face.grooves for face in self.sections_of_rough_faces.values())
        return any(
            lay != first[0] or abs(math.remainder(angle - first[1], math.pi)) > SAME_ANGLE
            for lay, angle in others
        )

    @property
    def lay(self) -> float:
        """γ, the ratio of lengths along the grooves and across; 1 is isotropic."""
        return self.grooves[0]

    @property
    def directed_angle(self) -> float | None:
        """The angle from which directions of surfaces drawn by C(q⃗) count, radians; None if they are not so drawn.

        It is that of the lay of a scan, 0 of faces whose lays differ. Where contact slides, or with tables over
        temperature, surfaces are isotropic.
        """
        if self.sliding.history == SLIDING or self.tables:
            return None
        angles = (face.directed for face in self.sections_of_rough_faces.values())
        none = 0.0 if self.lays_differ else None
        return next((angle for angle in angles if angle is not None), none)

    @cached_property  # as this
    def directions(self) -> tuple[float, ...]:
        """Directions of sliding with results of their own, radians from x; none of isotropic faces."""
        lay = self.directed_angle
        if lay is None and self.lay == 1.0:
            return ()
        return self.sliding.direction or tuple((lay or 0.0) + turn for turn in _DIRECTIONS)

    @property
    def first_direction(self) -> dict[str, float]:
        """The label of the first direction with results of its own, for `Estimate.sel`; none of isotropic faces."""
        return {"direction": self.directions[0]} if self.directions else {}

    @property
    def headings(self) -> tuple[float, ...] | None:
        """The direction of each entry of `speeds`, radians from the grooves; None of isotropic faces."""
        start, each = self.grooves[1], len(self.sliding.speed)
        turned = (math.remainder(angle - start, math.tau) for angle in self.directions)
        return tuple(angle for angle in turned for _ in range(each)) or None

    @property
    def lay_along_slide(self) -> float:
        """The lay of faces that slide along their grooves, 1/γ if across: by it the slide stretches their cell."""
        across = abs(math.sin((self.headings or (0.0,))[0])) > 0.5
        return 1.0 / self.lay if across else self.lay

    @property
    def speeds(self) -> tuple[float, ...]:
        """Speed of each result, m/s: all speeds in the first of the `directions`, then all in the next."""
        return self.sliding.speed * max(len(self.directions), 1)

    @property
    def cases(self) -> list[dict[str, float]]:
        """The labels of each entry of `speeds`: its "speed", m/s, and of faces with a lay its "direction", radians."""
        each = [{"speed": speed} for speed in self.sliding.speed]
        turned = [{"direction": angle, **one} for angle in self.directions for one in each]
        return turned or each


def _face_spectrum(face: SurfaceSection | CounterfaceSection, directed: bool) -> Face:
    """Return C(q) of one face, m⁴, with the directions of its scan or of its lay if `directed`."""
    spectrum, (lay, angle) = _isotropic_spectrum(face), face.grooves
    if directed and face.psd_directions is not None:
        return DirectedSpectrum(spectrum, directions_of(face.psd_directions))
    return with_lays([(spectrum, lay, angle)]) if directed and lay > 1.0 else spectrum


def _isotropic_spectrum(face: SurfaceSection | CounterfaceSection) -> Face:
    """Return C(q) of one face, m⁴, in Persson's convention, before its lay stretches it."""
    if face.spectrum is not None:
        return TruncatedSpectrum(face.spectrum)
    if face.psd is not None:
        q, psd = np.array(face.psd).T
        per_row, factor = PSD_SCALES[face.psd_convention or ""]
        return TabulatedSpectrum(per_row * q, factor * psd)
    shape: dict[str, Any] = {
        key: getattr(face, key) for key in ("hurst", "q_min", "q_max", "q_roll_off")
    }
    shape["roll_off_exponent"] = face.roll_off_exponent or 0.0
    if face.rms_height is not None:
        return SelfAffineSpectrum.from_rms_height(face.rms_height, **shape)
    slope = (face.rms_slope or 0.0) / steeper(face.lay or 1.0)
    return SelfAffineSpectrum.from_rms_slope(slope, **shape)


def steeper(lay: float) -> float:
    """Return the rms slope of a surface with a lay over that of the isotropic one that it stretches."""
    return math.sqrt((lay + 1.0 / lay) / 2.0)
