"""Shader node graphs: what a socket gets, through reroutes, muted nodes and groups."""

from __future__ import annotations

from dataclasses import dataclass

import bpy


@dataclass(frozen=True)
class Output:
    """An output socket, with the group nodes that were entered on the way to it."""

    node: bpy.types.Node
    socket: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...] = ()

    def input(self, *names: str) -> Input | None:
        """The node's input of the first of these names that it has: Blender renames some between versions."""
        for name in names:
            found = next((s for s in self.node.inputs if name in (s.name, s.identifier) and s.enabled), None)
            if found is not None:
                return Input(found, self.groups)
        return None

    def inputs(self) -> list[Input]:
        return [Input(socket, self.groups) for socket in self.node.inputs if socket.enabled]

    @property
    def kind(self) -> str:
        return self.node.bl_idname


@dataclass(frozen=True)
class Input:
    """An input socket, with the group nodes that were entered on the way to it."""

    socket: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...] = ()

    @property
    def name(self) -> str:
        return self.socket.name

    def source(self) -> Output | None:
        """The output that feeds it; `None` where its own value counts."""
        return self.resolved()[1]

    def default(self) -> float | tuple[float, ...]:
        """The value where nothing feeds it."""
        socket = self.resolved()[0].socket
        value = getattr(socket, "default_value", 0.0)
        return value if isinstance(value, (int, float)) else tuple(value)

    def resolved(self) -> tuple[Input, Output | None]:
        """The input that has the last word, which is another one inside groups, and what feeds that."""
        here = self
        while True:
            links = [link for link in here.socket.links if link.is_valid and not link.is_muted]
            if not links:
                return here, None
            node, socket = links[0].from_node, links[0].from_socket
            if node.bl_idname == "NodeReroute":
                here = Input(node.inputs[0], here.groups)
            elif node.mute:
                passed = next((link.from_socket for link in node.internal_links if link.to_socket == socket), None)
                if passed is None:
                    return here, None
                here = Input(passed, here.groups)
            elif node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None:
                end = next((n for n in node.node_tree.nodes if n.bl_idname == "NodeGroupOutput" and n.is_active_output), None)
                inner = end and next((s for s in end.inputs if s.identifier == socket.identifier), None)
                if inner is None:
                    return here, None
                here = Input(inner, (*here.groups, node))
            elif node.bl_idname == "NodeGroupInput" and here.groups:
                group = here.groups[-1]
                here = Input(next(s for s in group.inputs if s.identifier == socket.identifier), here.groups[:-1])
            else:
                return here, Output(node, socket, here.groups)


def tree_of(owner: bpy.types.Material | bpy.types.World) -> bpy.types.NodeTree | None:
    """Its nodes; before Blender 5 they could be switched off."""
    return owner.node_tree if bpy.app.version >= (5, 0, 0) or owner.use_nodes else None


def surface(tree: bpy.types.NodeTree | None, socket: str) -> Output | None:
    """What is plugged into an output node: `Surface`, `Volume` or `Displacement`, as Cycles would take it."""
    output = tree.get_output_node("CYCLES") if tree is not None else None
    return Input(output.inputs[socket]).source() if output is not None else None
