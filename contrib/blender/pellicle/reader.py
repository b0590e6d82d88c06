"""Reads the sockets of one material: numbers, colours, maps; remarks on what is left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from .field import Evaluation, Field, Unsupported
from .graph import Input, Output
from .notes import Notes
from .numerals import real, reals
from .picture import Picture, Pictures, colorspace, picture_of, refer
from .texcoord import TexCoord

Rgb = tuple[float, float, float]

THICKEST_NM = 50_000.0
# Names of inputs in the order of newer to older versions.
FILM_THICKNESS = ("Thin Film Thickness",)
FILM_IOR = ("Thin Film IOR",)


@dataclass
class Reader:
    material: str
    # Animated materials keep films that are absent in the first frame.
    animated: bool
    pictures: Pictures
    notes: Notes
    # Length of the ways through the body in Blender units, for glass that is coloured by nothing but a tint.
    chord: Callable[[], float]
    meter: float
    texcoords: set[TexCoord] = field(default_factory=set)

    def note(self, what: str, advice: str) -> None:
        self.notes.add(f"material `{self.material}`: {what}", advice)

    def unsupported(self, fault: Unsupported, socket: Input, instead: str) -> None:
        self.note(f"{fault} at `{socket.name}`", f"is not translated; {instead}")

    def rgb(self, socket: Input | None, absent: Rgb = (1.0, 1.0, 1.0)) -> Rgb:
        """A colour that has to be the same everywhere: the mean of an image."""
        if socket is None:
            return absent
        values = self._evaluate(socket, Field.rgb)
        if values.size > 3:
            self.note(f"an image at `{socket.name}`", "its mean colour is written")
        return tuple(float(value) for value in values.mean(axis=(0, 1)))

    def number(self, socket: Input | None, absent: float = 0.0) -> float:
        """A number that has to be the same everywhere: the mean of an image."""
        if socket is None:
            return absent
        values = self._evaluate(socket, Field.grey)
        if values.size > 1:
            self.note(f"an image at `{socket.name}`", "its mean is written")
        return float(values.mean())

    def _evaluate(self, socket: Input, channels: Callable[[Field], np.ndarray]) -> np.ndarray:
        try:
            return channels(Evaluation().at(socket))
        except Unsupported as fault:
            self.unsupported(fault, socket, "the socket's own value is written")
            return channels(Field.constant(_own(socket)))

    def reflectance(self, base: Element, socket: Input) -> Rgb:
        """A colour or a map of it; the colour for readers that know no maps."""
        source = socket.source()
        if source is not None and source.kind == "ShaderNodeTexImage" and source.socket.name == "Color":
            picture = picture_of(source)
            if picture is not None:
                element = self._map(base, "map", self.pictures.copy(picture.image), picture, purpose="reflectance")
                if not picture.image.is_float:
                    element.set("colorspace", colorspace(picture.image, self.notes))
                return (0.5, 0.5, 0.5)
        values = self._field(socket)
        rgb = np.clip(values.rgb(), 0.0, 1.0)
        if values.picture is not None:
            uri = self.pictures.bake(f"{self.material}_{socket.name}", rgb)
            self._map(base, "map", uri, values.picture, purpose="reflectance").set("colorspace", "linear")
        else:
            base.set("reflectance", reals(rgb.ravel(), 7))
        return tuple(float(value) for value in rgb.mean(axis=(0, 1)))

    def roughness(self, base: Element, socket: Input | None) -> None:
        """Blender squares its roughness; ours is the alpha of the distribution itself."""
        if socket is None:
            return
        values = self._field(socket)
        alpha = np.clip(values.grey(), 0.0, 1.0) ** 2
        if values.picture is not None:
            uri = self.pictures.bake(f"{self.material}_{socket.name}", alpha)
            self._map(base, "map", uri, values.picture, purpose="roughness").set("colorspace", "linear")
        elif alpha.mean() > 0.0:
            base.set("roughness", real(float(alpha.mean()), 7))

    def film(self, base: Element, output: Output) -> bool:
        """The thin film of a node that has one. True if there is a film."""
        thickness, ior = output.input(*FILM_THICKNESS), output.input(*FILM_IOR)
        if thickness is None or ior is None:
            return False
        evaluations = [Evaluation(noise=0.0), Evaluation(noise=1.0)]
        try:
            thin, thick = (evaluation.at(thickness).grey() for evaluation in evaluations)
            picture = evaluations[0].at(thickness).picture
        except Unsupported as fault:
            self.unsupported(fault, thickness, "the socket's own value is written")
            thin = thick = Field.constant(_own(thickness)).grey()
            picture = None
        if not self.animated and max(thin.max(), thick.max()) < 1.0:
            return False
        element = SubElement(base, "film", ior=real(self.number(ior, 1.33), 7))
        if picture is not None:
            self._film_map(element, thin, picture)
        else:
            low, high = self._nm(float(thin.min())), self._nm(float(thick.max()))
            element.set("thickness_nm", real(0.5 * (low + high), 7))
            if evaluations[0].noise_node is not None and high > low:
                self._film_noise(element, evaluations[0].noise_node, low, high)
        return True

    def _film_map(self, element: Element, thickness: np.ndarray, picture: Picture) -> None:
        low, high = self._nm(float(thickness.min())), self._nm(float(thickness.max()))
        share = (thickness - low) / (high - low) if high > low else np.zeros_like(thickness)
        uri = self.pictures.bake(f"{self.material}_thickness", share)
        self._map(element, "map", uri, picture, min_nm=real(low), max_nm=real(high))

    def _film_noise(self, element: Element, node: Output, low: float, high: float) -> None:
        scale, detail = (self.number(node.input(name)) for name in ("Scale", "Detail"))
        amplitude = (high - low) / (high + low)
        octaves = min(max(round(detail) + 1, 1), 16)
        SubElement(element, "noise", amplitude=real(amplitude, 7), frequency=real(scale, 7), octaves=str(octaves))
        self.note(f"the noise of the film's thickness (`{node.node.name}`)", "another pattern of the same size and range")

    def _nm(self, thickness: float) -> float:
        if thickness > THICKEST_NM:
            self.note(f"a film of {thickness:.6g} nm", f"{THICKEST_NM:.0f} nm are written")
        # The renderer takes fractions of a nanometre for micrometres.
        return min(thickness, THICKEST_NM) if thickness >= 1.0 else float(round(max(thickness, 0.0)))

    def normal(self, base: Element, output: Output) -> None:
        """The normal map of a node; other ways to bend normals are noted."""
        socket = output.input("Normal")
        source = socket.source() if socket is not None else None
        if source is None:
            return
        colour = source.input("Color") if source.kind == "ShaderNodeNormalMap" else None
        image = colour.source() if colour is not None else None
        picture = picture_of(image) if image is not None and image.kind == "ShaderNodeTexImage" else None
        if picture is None or source.node.space != "TANGENT":
            self.note(f"the node `{source.node.name}` at `Normal`", "is not translated; the mesh's normals are used")
            return
        if picture.image.colorspace_settings.name == "sRGB":
            self.note(f"the normal map `{picture.image.name}` is sRGB", "it is read as data")
        element = self._map(base, "normal_map", self.pictures.copy(picture.image), picture)
        strength = self.number(source.input("Strength"), 1.0)
        if strength != 1.0:
            element.set("scale", real(strength, 7))

    def opacity(self, base: Element, socket: Input | None, inverted: bool = False) -> None:
        """Coverage from an alpha input, or from the factor of a mix with Transparent."""
        if socket is None:
            return
        values = self._field(socket)
        cover = np.clip(1.0 - values.grey() if inverted else values.grey(), 0.0, 1.0)
        if values.picture is not None:
            uri = self.pictures.bake(f"{self.material}_opacity", cover)
            self._map(base, "opacity", uri, values.picture, channel="g")
        elif cover.mean() < 1.0:
            SubElement(base, "opacity", value=real(float(cover.mean()), 7))

    def _field(self, socket: Input) -> Field:
        try:
            return Evaluation().at(socket)
        except Unsupported as fault:
            self.unsupported(fault, socket, "the socket's own value is written")
            return Field.constant(_own(socket))

    def _map(self, base: Element, tag: str, uri: str, picture: Picture, purpose: str = "", **more: str) -> Element:
        self.texcoords.add(picture.texcoord)
        element = SubElement(base, tag, {"for": purpose} if purpose else {})
        refer(element, uri, picture)
        element.attrib.update(more)
        return element

    def unused(self, output: Output, harmless: dict[str, float]) -> None:
        """Notes inputs that the translation has no use for, where they are not what makes them harmless."""
        for name, value in harmless.items():
            socket = output.input(name)
            if socket is not None and (socket.source() is not None or abs(self.number(socket) - value) > 1e-6):
                self.note(f"`{name}`", "is not translated")


def _own(socket: Input) -> float | tuple[float, ...]:
    value = getattr(socket.socket, "default_value", 0.0)
    return value if isinstance(value, (int, float)) else tuple(value)[:3]
