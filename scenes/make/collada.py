"""Files: pictures, and scenes in COLLADA."""

import pathlib
import struct
import zipfile
import zlib

from .vectors import add, cross, numbers, scaled, sub, unit

FOLDER = pathlib.Path(__file__).resolve().parent.parent


def png(width, height, value, bits=16, channels=1):
    """A picture of value(u, v) in 0..1, a number or as many as there are channels; v runs upwards."""
    white, layout = (65535, ">%dH" % (width * channels)) if bits == 16 else (255, "%dB" % (width * channels))
    rows = []
    for j in range(height):
        texels = [value((i + 0.5) / width, 1 - (j + 0.5) / height) for i in range(width)]
        samples = [x for texel in texels for x in texel] if channels > 1 else texels
        rows.append(b"\0" + struct.pack(layout, *(round(white * min(max(x, 0), 1)) for x in samples)))
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, bits, 2 if channels == 3 else 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"".join(rows), 9)) + chunk(b"IEND", b"")


def attributes(**values):
    """XML attributes; tuples become lists of numbers, None is left out."""
    text = lambda v: numbers(v) if isinstance(v, tuple) else "%g" % v if isinstance(v, (int, float)) else v
    return "".join(f' {name}="{text(value)}"' for name, value in values.items() if value is not None)


def extra(profile, content):
    return f'<extra><technique profile="{profile}">{content}</technique></extra>'


class Scene:
    """Collects the libraries of a COLLADA document."""

    def __init__(self, title):
        self.title = title
        self.cameras, self.lights, self.effects, self.materials, self.geometries, self.nodes = ([] for _ in range(6))
        self.animations = []
        self.surroundings = self.hints = ""

    def material(self, name, color, base):
        """`base`: the element of our profile; `color`: what other COLLADA readers show."""
        common = f"<lambert><diffuse><color>{numbers(color)} 1</color></diffuse></lambert>"
        self.effects.append(f'<effect id="{name}-fx"><profile_COMMON><technique sid="common">{common}</technique>'
                            f'</profile_COMMON>{extra("pellicle", base)}</effect>')
        self.materials.append(f'<material id="{name}"><instance_effect url="#{name}-fx"/></material>')
        return name

    def mesh(self, name, mesh):
        positions, normals, uvs, triangles = mesh
        sources = self.source(name + "-p", "XYZ", positions) + self.source(name + "-n", "XYZ", normals)
        inputs = (f'<input semantic="VERTEX" source="#{name}-v" offset="0"/>'
                  f'<input semantic="NORMAL" source="#{name}-n" offset="0"/>')
        if uvs:
            sources += self.source(name + "-t", "ST", uvs)
            inputs += f'<input semantic="TEXCOORD" source="#{name}-t" offset="0" set="0"/>'
        indices = " ".join("%d %d %d" % t for t in triangles)
        self.geometries.append(f'<geometry id="{name}"><mesh>{sources}<vertices id="{name}-v"><input semantic="POSITION" '
                               f'source="#{name}-p"/></vertices>\n<triangles count="{len(triangles)}" material="m">{inputs}'
                               f'<p>{indices}</p></triangles></mesh></geometry>')
        return name

    @staticmethod
    def source(name, axes, rows):
        values = " ".join(numbers(row) for row in rows)
        params = "".join(f'<param name="{axis}" type="float"/>' for axis in axes)
        return (f'<source id="{name}"><float_array id="{name}-a" count="{len(rows) * len(axes)}">{values}</float_array>'
                f'<technique_common><accessor source="#{name}-a" count="{len(rows)}" stride="{len(axes)}">{params}'
                f'</accessor></technique_common></source>\n')

    def sphere(self, name, radius):
        ball = extra("CGL", f"<sphere><radius>{numbers([radius])}</radius></sphere>")
        self.geometries.append(f'<geometry id="{name}">{ball}</geometry>')
        return name

    def node(self, name, content, *transforms):
        """`transforms`: ("translate", x, y, z), ("rotate", x, y, z, degrees), ("scale", ...), ("lookat", ...)."""
        moves = "".join(f"<{kind}>{numbers(values)}</{kind}>" for kind, *values in transforms)
        self.nodes.append(f'<node id="{name}">{moves}{content}</node>')

    def place(self, geometry, material, *transforms, name=None):
        instance = (f'<instance_geometry url="#{geometry}"><bind_material><technique_common><instance_material symbol="m" '
                    f'target="#{material}"/></technique_common></bind_material></instance_geometry>')
        self.node(name or geometry + "-node", instance, *transforms)

    def ball(self, name, material, radius, *centre):
        self.place(self.sphere(name, radius), material, ("translate", *centre))

    def camera(self, eye, target, xfov, aspect, lens=""):
        self.cameras.append(f'<camera id="camera"><optics><technique_common><perspective><xfov>{xfov:g}</xfov><aspect_ratio>'
                            f'{aspect:.5g}</aspect_ratio><znear>0.1</znear><zfar>10000</zfar></perspective></technique_common>'
                            f'</optics>{lens and extra("pellicle", lens)}</camera>')
        self.node("camera-node", '<instance_camera url="#camera"/>', ("lookat", *eye, *target, 0, 1, 0))

    def softbox(self, name, centre, target, width, height, radiance, **more):
        """A rectangular light that faces `target`."""
        area = f'<area{attributes(shape="rectangle", radiance=radiance, **more)}/>'
        common = f"<technique_common><point><color>{numbers(radiance)}</color></point></technique_common>"
        self.lights.append(f'<light id="{name}">{common}{extra("pellicle", area)}</light>')
        up = (0, 0, -1) if abs(unit(sub(target, centre))[1]) > 0.99 else (0, 1, 0)
        self.node(name + "-node", f'<instance_light url="#{name}"/>', ("lookat", *centre, *target, *up), ("scale", width, height, 1))

    def window(self, name, centre, target, width, height, columns, rows, radiance, bar=0.08):
        """A window of panes, the upper ones (sky) brighter than the lower ones (street)."""
        z = unit(sub(centre, target))
        x = unit(cross((0, 1, 0), z))
        y = cross(z, x)
        for j in range(rows):
            for i in range(columns):
                offset = add(scaled(x, width * ((i + 0.5) / columns - 0.5)), scaled(y, height * ((j + 0.5) / rows - 0.5)))
                pane = add(centre, offset)
                glow = scaled(radiance, 0.55 + 0.45 * (j + 1) / rows)
                self.softbox(f"{name}-{i}{j}", pane, sub(pane, z), width / columns * (1 - bar), height / rows * (1 - bar), glow)

    def steps(self, target, values):
        """Frame n of the animation, 24 to a second, has the n-th value."""
        name = f"steps-{len(self.animations)}"
        # Steps are half-way between frames, where rounding cannot reach.
        times = numbers((max(0, n - 0.5) / 24 for n in range(len(values))), 6)
        array = lambda part, kind, text, type: (
            f'<source id="{name}-{part}"><{kind} id="{name}-{part}-a" count="{len(values)}">{text}</{kind}><technique_common>'
            f'<accessor source="#{name}-{part}-a" count="{len(values)}" stride="1"><param name="{part}" type="{type}"/></accessor>'
            f'</technique_common></source>')
        inputs = "".join(f'<input semantic="{part}" source="#{name}-{part}"/>' for part in ("INPUT", "OUTPUT", "INTERPOLATION"))
        self.animations.append(
            f'<animation>{array("INPUT", "float_array", times, "float")}{array("OUTPUT", "float_array", numbers(values), "float")}'
            f'{array("INTERPOLATION", "Name_array", " ".join(["STEP"] * len(values)), "name")}<sampler id="{name}">{inputs}</sampler>'
            f'<channel source="#{name}" target="{target}"/></animation>')

    def environment(self, radiance, **more):
        self.surroundings = extra("pellicle", f"<environment{attributes(radiance=radiance, **more)}/>")

    def render(self, width, height, **hints):
        self.hints = extra("pellicle", f"<render{attributes(width=width, height=height, **hints)}/>")

    def xml(self):
        date = "2026-11-22T00:00:00Z"
        libraries = [("cameras", self.cameras), ("lights", self.lights), ("effects", self.effects),
                     ("materials", self.materials), ("geometries", self.geometries), ("animations", self.animations)]
        lines = ['<?xml version="1.0" encoding="utf-8"?>', f"<!-- {self.title} -->",
                 '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">',
                 f"<asset><contributor><authoring_tool>make_scenes.py</authoring_tool></contributor><created>{date}</created>"
                 f'<modified>{date}</modified><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>']
        for name, items in libraries:
            if items:
                lines += [f"<library_{name}>", *items, f"</library_{name}>"]
        lines += ['<library_visual_scenes><visual_scene id="scene">', *self.nodes, self.surroundings,
                  "</visual_scene></library_visual_scenes>",
                  f'<scene><instance_visual_scene url="#scene"/>{self.hints}</scene>', "</COLLADA>", ""]
        return "\n".join(line for line in lines if line or line is lines[-1])

    def save(self, name):
        (FOLDER / f"{name}.dae").write_text(self.xml(), encoding="utf-8")

    def save_packed(self, name):
        inside = pathlib.PurePath(name).name + ".dae"
        manifest = f'<?xml version="1.0" encoding="utf-8"?>\n<dae_root>{inside}</dae_root>\n'
        with zipfile.ZipFile(FOLDER / f"{name}.zae", "w") as archive:
            for member, text in (("manifest.xml", manifest), (inside, self.xml())):
                info = zipfile.ZipInfo(member, date_time=(2026, 11, 22, 0, 0, 0))
                info.compress_type, info.create_system = zipfile.ZIP_DEFLATED, 3
                archive.writestr(info, text.encode("utf-8"), compresslevel=9)


def film(thickness_nm=None, varying="", **more):
    """`varying`: a <noise>, <drain> or <map> element."""
    return f"<film{attributes(thickness_nm=thickness_nm, **more)}>{varying}</film>"


def diffuse(scene, name, color, films="", ior=None):
    return scene.material(name, color, f"<diffuse{attributes(reflectance=color, ior=ior)}>{films}</diffuse>")
