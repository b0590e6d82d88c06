"""Shader nodes as surfaces of the renderer: one base, its films, its maps."""

from __future__ import annotations

import math
from collections.abc import Callable
from xml.etree.ElementTree import Element, SubElement

from . import metal
from .graph import Output, Input
from .numerals import real, reals
from .reader import Reader, Rgb

# A base, and a plain colour for readers that do not know it.
Surface = tuple[Element, Rgb]

# Glossy layers over a matte base are smooth in the renderer: rougher ones than this look more like none.
_SMOOTH_LAYER = 0.3
_DARK = 1e-6


def surface(reader: Reader, output: Output) -> Surface:
    """The surface that a shader node makes; matte grey, with a remark, for nodes that are not known."""
    shader = _SHADERS.get(output.kind)
    if shader is None:
        reader.note(f"the shader `{output.node.name}` ({output.kind.removeprefix('ShaderNode')})", "matte grey is written")
        return Element("diffuse", reflectance="0.5"), (0.5, 0.5, 0.5)
    return shader(reader, output)


def _principled(reader: Reader, output: Output) -> Surface:
    metallic = reader.number(output.input("Metallic"))
    transmission = reader.number(output.input("Transmission Weight"))
    strength = reader.number(output.input("Emission Strength"))
    emission = tuple(strength * value for value in reader.rgb(output.input("Emission Color")))
    unused = {
        "Anisotropic": 0.0, "Coat Weight": 0.0, "Sheen Weight": 0.0, "Subsurface Weight": 0.0, "Diffuse Roughness": 0.0,
    }  # fmt: skip
    if max(emission) > _DARK:
        if max(reader.rgb(output.input("Base Color"))) > _DARK:
            reader.note("the surface under an emission", "only the light is written: base colour black says the same")
        return _emitter(emission)
    for name, share in (("Metallic", metallic), ("Transmission Weight", transmission)):
        if 0.0 < share < 1.0 and not (name == "Transmission Weight" and metallic >= 0.5):
            reader.note(f"`{name}` {share:.3g}", f"is written as {round(share)}: surfaces are not mixed")
    if metallic >= 0.5:
        f0 = reader.rgb(output.input("Base Color"))
        tint = reader.rgb(output.input("Specular Tint"))
        base, colour = _conductor(f0, [metal.schlick(f, metal.COS_82) * t for f, t in zip(f0, tint)]), f0
        reader.roughness(base, output.input("Roughness"))
    elif transmission >= 0.5:
        base, colour = Element("dielectric", ior=_ior(reader, output)), (1.0, 1.0, 1.0)
        reader.roughness(base, output.input("Roughness"))
        _tint(reader, base, reader.rgb(output.input("Base Color")), 1.0)
    else:
        return _plastic(reader, output, unused)
    reader.film(base, output)
    return _finished(reader, base, colour, output, unused, output.input("Alpha"))


def _plastic(reader: Reader, output: Output, unused: dict[str, float]) -> Surface:
    """Principled's matte base under its reflecting surface."""
    base = Element("diffuse")
    colour = reader.reflectance(base, output.input("Base Color"))
    roughness = reader.number(output.input("Roughness"))
    level = reader.number(output.input("Specular IOR Level"), 0.5)
    ior = reader.number(output.input("IOR"), 1.5)
    f0 = ((ior - 1.0) / (ior + 1.0)) ** 2 * 2.0 * level
    base.set("ior", real(max(metal.index_of_dielectric(f0), 1.0), 7))
    coat, coat_roughness = (reader.number(output.input(name)) for name in ("Coat Weight", "Coat Roughness"))
    if reader.film(base, output):
        if roughness > 0.0:
            reader.note(f"`Roughness` {roughness:.3g} of a film on a matte base", "the film is written smooth")
    elif coat >= 0.5 and coat_roughness <= _SMOOTH_LAYER:
        # A film without thickness is the body's own surface.
        ior_coat = real(reader.number(output.input("Coat IOR"), 1.5), 7)
        base.set("ior", ior_coat)
        SubElement(base, "film", ior=ior_coat, thickness_nm="0")
        reader.note("`Coat Weight` on a matte base", "is written as one smooth layer")
        unused.pop("Coat Weight")
    elif f0 > 0.0 and roughness <= _SMOOTH_LAYER:
        SubElement(base, "film", ior=base.get("ior", "1.5"), thickness_nm="0")
        if roughness > 0.0:
            reader.note(f"`Roughness` {roughness:.3g} of the gloss on a matte base", "the gloss is written smooth")
    elif f0 > 0.0:
        reader.note(f"the rough gloss on a matte base (`Roughness` {roughness:.3g})", "only the matte base is written")
    return _finished(reader, base, colour, output, unused, output.input("Alpha"))


def _metallic(reader: Reader, output: Output) -> Surface:
    if output.node.fresnel_type == "PHYSICAL_CONDUCTOR":
        eta, k = reader.rgb(output.input("IOR")), reader.rgb(output.input("Extinction"))
        base = Element("conductor", eta=reals(eta, 7), k=reals(k, 7))
        colour = tuple(metal.reflectance(*pair, 1.0) for pair in zip(eta, k))
    else:
        colour = reader.rgb(output.input("Base Color"))
        tint = reader.rgb(output.input("Edge Tint"))
        base = _conductor(colour, [metal.schlick(f, metal.COS_82) * t for f, t in zip(colour, tint)])
    return _rough_metal(reader, base, colour, output)


def _glossy(reader: Reader, output: Output) -> Surface:
    # Glossy reflects the same share at every angle.
    colour = reader.rgb(output.input("Color"))
    return _rough_metal(reader, _conductor(colour, colour), colour, output)


def _rough_metal(reader: Reader, base: Element, colour: Rgb, output: Output) -> Surface:
    reader.roughness(base, output.input("Roughness"))
    _distribution(base, output)
    reader.film(base, output)
    return _finished(reader, base, colour, output, {"Anisotropy": 0.0})


def _glass(reader: Reader, output: Output) -> Surface:
    base = Element("dielectric", ior=_ior(reader, output))
    if output.kind == "ShaderNodeBsdfRefraction":
        reader.note("the shader Refraction", "is written as glass, which also reflects")
    reader.roughness(base, output.input("Roughness"))
    _distribution(base, output)
    # Glass is tinted where light enters and where it leaves.
    _tint(reader, base, reader.rgb(output.input("Color")), 2.0)
    reader.film(base, output)
    return _finished(reader, base, (1.0, 1.0, 1.0), output, {})


def _diffuse(reader: Reader, output: Output) -> Surface:
    base = Element("diffuse")
    colour = reader.reflectance(base, output.input("Color"))
    return _finished(reader, base, colour, output, {"Roughness": 0.0})


def _emission(reader: Reader, output: Output) -> Surface:
    strength = reader.number(output.input("Strength"), 1.0)
    return _emitter(tuple(strength * value for value in reader.rgb(output.input("Color"))))


def _mix(reader: Reader, output: Output) -> Surface:
    factor, first, second = output.inputs()
    sources = [first.source(), second.source()]
    share = reader.number(factor) if factor.source() is None else None
    if share in (0.0, 1.0):
        chosen = sources[int(share)]
        return surface(reader, chosen) if chosen is not None else _nothing()
    for clear, other in ((0, 1), (1, 0)):
        hole, there = sources[clear], sources[other]
        if hole is not None and hole.kind == "ShaderNodeBsdfTransparent":
            base, colour = surface(reader, there) if there is not None else _nothing()
            if base.tag == "emitter":
                reader.note("a mix of light and Transparent", "the light is written whole")
            elif base.find("opacity") is None:
                reader.opacity(base, factor, inverted=clear == 1)
            return base, colour
    share = reader.number(factor)
    chosen = sources[1 if share >= 0.5 else 0]
    reader.note(f"the mix `{output.node.name}` of two shaders", "the one with the greater share is written")
    return surface(reader, chosen) if chosen is not None else _nothing()


def _add(reader: Reader, output: Output) -> Surface:
    first, second = (socket.source() for socket in output.inputs())
    if first is None or second is None:
        only = first or second
        return surface(reader, only) if only is not None else _nothing()
    chosen = second if first.kind == "ShaderNodeEmission" else first
    reader.note(f"the sum `{output.node.name}` of two shaders", f"only `{chosen.node.name}` is written")
    return surface(reader, chosen)


def _transparent(reader: Reader, output: Output) -> Surface:
    return _nothing()


def _nothing() -> Surface:
    """A surface that is not there."""
    base = Element("diffuse", reflectance="0")
    SubElement(base, "opacity", value="0")
    return base, (0.0, 0.0, 0.0)


def _matte_instead(reader: Reader, output: Output) -> Surface:
    reader.note(f"the shader `{output.node.name}`", "is written as a matte surface of its colour")
    return _diffuse(reader, output)


def _emitter(radiance: Rgb) -> Surface:
    brightest = max(max(radiance), 1.0)
    return Element("emitter", radiance=reals(radiance, 7)), tuple(value / brightest for value in radiance)


def _conductor(f0: Rgb, f82: list[float] | Rgb) -> Element:
    pairs = [metal.index(*wave) for wave in zip(metal.wave_reflectances(f0), metal.wave_reflectances(f82))]
    return Element("conductor", eta=reals([n for n, _ in pairs], 7), k=reals([k for _, k in pairs], 7))


def _ior(reader: Reader, output: Output) -> str:
    ior = reader.number(output.input("IOR"), 1.5)
    if ior < 1.0:
        reader.note(f"`IOR` {ior:.3g}", "below 1 is written as 1")
    return real(min(max(ior, 1.0), 5.0), 7)


def _tint(reader: Reader, base: Element, tint: Rgb, crossings: float) -> None:
    """Colour at the surface becomes absorption inside: the same for ways of the body's mean length."""
    if min(tint) >= 1.0 - 1e-4:
        return
    chord = reader.chord() * reader.meter
    if chord <= 0.0 or base.get("ior") == "1":
        reader.note("the tint of glass", "is left out: the body is not closed, or a thin sheet")
        return
    absorption = [-crossings * math.log(max(value, 1e-4)) / chord for value in tint]
    base.set("absorption_per_m", reals([max(value, 0.0) for value in absorption], 7))
    reader.note("the tint of glass", f"is written as absorption, alike for ways of {chord:.3g} m, the body's mean")


def _distribution(base: Element, output: Output) -> None:
    if getattr(output.node, "distribution", "") == "BECKMANN":
        base.set("distribution", "beckmann")


def _finished(
    reader: Reader, base: Element, colour: Rgb, output: Output, unused: dict[str, float], alpha: Input | None = None
) -> Surface:
    reader.normal(base, output)
    reader.opacity(base, alpha)
    reader.unused(output, unused)
    return base, colour


_SHADERS: dict[str, Callable[[Reader, Output], Surface]] = {
    "ShaderNodeBsdfPrincipled": _principled,
    "ShaderNodeBsdfMetallic": _metallic,
    "ShaderNodeBsdfAnisotropic": _glossy,
    "ShaderNodeBsdfGlossy": _glossy,
    "ShaderNodeBsdfGlass": _glass,
    "ShaderNodeBsdfRefraction": _glass,
    "ShaderNodeBsdfDiffuse": _diffuse,
    "ShaderNodeBsdfTransparent": _transparent,
    "ShaderNodeEmission": _emission,
    "ShaderNodeMixShader": _mix,
    "ShaderNodeAddShader": _add,
    "ShaderNodeBsdfTranslucent": _matte_instead,
    "ShaderNodeSubsurfaceScattering": _matte_instead,
    "ShaderNodeBsdfSheen": _matte_instead,
    "ShaderNodeBsdfToon": _matte_instead,
}
