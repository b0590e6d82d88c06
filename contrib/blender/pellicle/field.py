"""Values over a surface: what a chain of nodes makes of constants and images.

A field is an array (rows, columns, channels), the upper row first; a constant has one row and one column. Chains of the nodes
below are worked out texel by texel and written as one image; any other node stops the chain with its name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import bpy
import numpy as np

from .graph import Input, Output
from .picture import Picture, linear_pixels, picture_of

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class Unsupported(Exception):
    """A node that cannot be translated, by its name."""

    def __init__(self, node: bpy.types.Node) -> None:
        super().__init__(f"the node `{node.name}` ({node.bl_idname.removeprefix('ShaderNode')})")


@dataclass(frozen=True)
class Field:
    pixels: np.ndarray
    # Where the texels lie on the surface; `None` for constants.
    picture: Picture | None = None

    @classmethod
    def constant(cls, value: float | tuple[float, ...]) -> Field:
        return cls(np.reshape(np.asarray(value, np.float64), (1, 1, -1)))

    def grey(self) -> np.ndarray:
        """One channel, as Blender turns colours to numbers."""
        if self.pixels.shape[2] == 1:
            return self.pixels
        return (self.pixels[:, :, :3] @ _LUMINANCE)[:, :, None]

    def rgb(self) -> np.ndarray:
        return np.repeat(self.pixels, 3, axis=2) if self.pixels.shape[2] == 1 else self.pixels[:, :, :3]


_BINARY: dict[str, Callable[..., np.ndarray]] = {
    "ADD": np.add,
    "SUBTRACT": np.subtract,
    "MULTIPLY": np.multiply,
    "DIVIDE": lambda a, b: np.divide(a, b, out=np.zeros(np.broadcast(a, b).shape), where=b != 0.0),
    "POWER": lambda a, b: np.power(np.maximum(a, 0.0), b),
    "MINIMUM": np.minimum,
    "MAXIMUM": np.maximum,
    "LESS_THAN": np.less,
    "GREATER_THAN": np.greater,
    "SQRT": lambda a, _: np.sqrt(np.maximum(a, 0.0)),
    "ABSOLUTE": lambda a, _: np.abs(a),
}

_BLENDS: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "MIX": lambda a, b: b,
    "MULTIPLY": np.multiply,
    "ADD": np.add,
    "SUBTRACT": np.subtract,
    "DARKEN": np.minimum,
    "LIGHTEN": np.maximum,
    "SCREEN": lambda a, b: 1.0 - (1.0 - a) * (1.0 - b),
}


@dataclass
class Evaluation:
    """Works out sockets. Noise Texture nodes give `noise`, and `noise_node` remembers one that was met."""

    noise: float | None = None
    noise_node: Output | None = None

    def at(self, socket: Input) -> Field:
        output = socket.source()
        return Field.constant(socket.default()) if output is None else self.of(output)

    def of(self, output: Output) -> Field:
        """Raises `Unsupported`."""
        node, kind = output.node, output.kind
        if kind in ("ShaderNodeValue", "ShaderNodeRGB"):
            value = node.outputs[0].default_value
            return Field.constant(value if kind == "ShaderNodeValue" else tuple(value)[:3])
        if kind == "ShaderNodeTexImage":
            picture = picture_of(output)
            if picture is None:
                raise Unsupported(node)
            pixels = linear_pixels(picture.image)
            return Field(pixels[:, :, 3:] if output.socket.name == "Alpha" else pixels[:, :, :3], picture)
        if kind == "ShaderNodeTexNoise" and self.noise is not None:
            self.noise_node = output
            return Field.constant(self.noise)
        work = _NODES.get(kind)
        if work is None:
            raise Unsupported(node)
        return work(self, output)

    def inputs(self, output: Output, *names: str) -> tuple[list[np.ndarray], Picture | None]:
        """The grey values of several inputs, by names or, without any, of all."""
        sockets = [output.input(name) for name in names] if names else output.inputs()
        fields = [self.at(socket) for socket in sockets if socket is not None]
        return [field.grey() for field in fields], shared(output, fields)


def shared(output: Output, fields: list[Field]) -> Picture | None:
    """The place of the texels, when those of all fields lie alike."""
    pictures = [field.picture for field in fields if field.picture is not None]
    sizes = {field.pixels.shape[:2] for field in fields if field.picture is not None}
    if len(sizes) > 1 or any(picture.place() != pictures[0].place() for picture in pictures):
        raise Unsupported(output.node)
    return pictures[0] if pictures else None


def _math(evaluation: Evaluation, output: Output) -> Field:
    operation = output.node.operation
    values, picture = evaluation.inputs(output)
    if operation == "MULTIPLY_ADD":
        result = values[0] * values[1] + values[2]
    elif operation in _BINARY:
        result = np.asarray(_BINARY[operation](values[0], values[1] if len(values) > 1 else 0.0), np.float64)
    else:
        raise Unsupported(output.node)
    return Field(np.clip(result, 0.0, 1.0) if output.node.use_clamp else result, picture)


def _map_range(evaluation: Evaluation, output: Output) -> Field:
    node = output.node
    if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
        raise Unsupported(node)
    values, picture = evaluation.inputs(output, "Value", "From Min", "From Max", "To Min", "To Max")
    value, from_min, from_max, to_min, to_max = values
    share = _BINARY["DIVIDE"](value - from_min, from_max - from_min)
    share = np.clip(share, 0.0, 1.0) if node.clamp else share
    return Field(to_min + share * (to_max - to_min), picture)


def _clamp(evaluation: Evaluation, output: Output) -> Field:
    (value, low, high), picture = evaluation.inputs(output, "Value", "Min", "Max")
    return Field(np.clip(value, low, high), picture)


def _mix(evaluation: Evaluation, output: Output) -> Field:
    node = output.node
    is_old = output.kind == "ShaderNodeMixRGB"
    kind = "RGBA" if is_old else node.data_type
    blend = node.blend_type if kind == "RGBA" else "MIX"
    if kind not in ("RGBA", "FLOAT") or blend not in _BLENDS:
        raise Unsupported(node)
    factor, a, b = (evaluation.at(socket) for socket in output.inputs())
    picture = shared(output, [factor, a, b])
    t = factor.grey()
    t = np.clip(t, 0.0, 1.0) if is_old or node.clamp_factor else t
    a, b = (a.rgb(), b.rgb()) if kind == "RGBA" else (a.grey(), b.grey())
    result = a + t * (_BLENDS[blend](a, b) - a)
    clamped = node.use_clamp if is_old else kind == "RGBA" and node.clamp_result
    return Field(np.clip(result, 0.0, 1.0) if clamped else result, picture)


def _invert(evaluation: Evaluation, output: Output) -> Field:
    factor, colour = (evaluation.at(socket) for socket in output.inputs())
    rgb = colour.rgb()
    return Field(rgb + factor.grey() * (1.0 - 2.0 * rgb), shared(output, [factor, colour]))


def _gamma(evaluation: Evaluation, output: Output) -> Field:
    colour, gamma = (evaluation.at(socket) for socket in output.inputs())
    return Field(np.maximum(colour.rgb(), 0.0) ** gamma.grey(), shared(output, [colour, gamma]))


def _contrast(evaluation: Evaluation, output: Output) -> Field:
    colour, bright, contrast = (evaluation.at(socket) for socket in output.inputs())
    a = 1.0 + contrast.grey()
    b = bright.grey() - contrast.grey() * 0.5
    return Field(np.maximum(a * colour.rgb() + b, 0.0), shared(output, [colour, bright, contrast]))


def _ramp(evaluation: Evaluation, output: Output) -> Field:
    field = evaluation.at(output.inputs()[0])
    # A ramp is read at enough places for its steps not to show in 16 bits of most.
    places = np.linspace(0.0, 1.0, 4097)
    table = np.array([output.node.color_ramp.evaluate(place) for place in places])
    channels = [3] if output.socket.name == "Alpha" else [0, 1, 2]
    grey = field.grey()[:, :, 0]
    return replace(field, pixels=np.stack([np.interp(grey, places, table[:, c]) for c in channels], axis=2))


def _separate(evaluation: Evaluation, output: Output) -> Field:
    if getattr(output.node, "mode", "RGB") != "RGB":
        raise Unsupported(output.node)
    field = evaluation.at(output.inputs()[0])
    channel = list(output.node.outputs).index(output.socket)
    return replace(field, pixels=field.rgb()[:, :, channel : channel + 1])


def _to_grey(evaluation: Evaluation, output: Output) -> Field:
    field = evaluation.at(output.inputs()[0])
    return replace(field, pixels=field.grey())


_NODES: dict[str, Callable[[Evaluation, Output], Field]] = {
    "ShaderNodeMath": _math,
    "ShaderNodeMapRange": _map_range,
    "ShaderNodeClamp": _clamp,
    "ShaderNodeMix": _mix,
    "ShaderNodeMixRGB": _mix,
    "ShaderNodeInvert": _invert,
    "ShaderNodeGamma": _gamma,
    "ShaderNodeBrightContrast": _contrast,
    "ShaderNodeValToRGB": _ramp,
    "ShaderNodeSeparateColor": _separate,
    "ShaderNodeRGBToBW": _to_grey,
}
