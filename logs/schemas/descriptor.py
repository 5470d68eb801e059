"""A protobuf file descriptor of dataclasses, built at import: no generated code, no version to match."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Union, get_args, get_origin, get_type_hints

from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto

PACKAGE = "topomap"
SCALARS: dict[type, FieldDescriptorProto.Type.ValueType] = {
    bool: FieldDescriptorProto.TYPE_BOOL,
    int: FieldDescriptorProto.TYPE_INT64,
    float: FieldDescriptorProto.TYPE_DOUBLE,
    str: FieldDescriptorProto.TYPE_STRING,
}


@dataclass(frozen=True, slots=True)
class Shape:
    """A record's field: its name, the type of one value, and whether values are records, a tuple, may be None."""

    name: str
    kind: type
    nested: bool
    repeated: bool = False
    optional: bool = False


@cache
def shapes(record: type) -> tuple[Shape, ...]:
    """Return the fields of a record class; raises TypeError for a type that has no protobuf form here."""
    hints = get_type_hints(record)
    return tuple(_shape(field.name, hints[field.name]) for field in fields(record))


def _shape(name: str, hint: object) -> Shape:
    origin, args = get_origin(hint), get_args(hint)
    if origin is tuple and len(args) == 2 and args[1] is Ellipsis:
        return Shape(name, args[0], is_dataclass(args[0]), repeated=True)
    if origin in (Union, UnionType) and NoneType in args and len(args) == 2:
        kind = next(arg for arg in args if arg is not NoneType)
        return Shape(name, kind, is_dataclass(kind), optional=True)
    if isinstance(hint, type) and (hint in SCALARS or is_dataclass(hint)):
        return Shape(name, hint, is_dataclass(hint))
    raise TypeError(f"no protobuf form for {name}: {hint}")


def file_descriptor(records: Sequence[type]) -> FileDescriptorProto:
    """Return the file `topomap.proto` with one message per record class, nested ones must be among them."""
    file = FileDescriptorProto(name=f"{PACKAGE}.proto", package=PACKAGE, syntax="proto3")
    file.message_type.extend(_message(record) for record in records)
    return file


def _message(record: type) -> DescriptorProto:
    message = DescriptorProto(name=record.__name__)
    for number, shape in enumerate(shapes(record), start=1):
        field = message.field.add(name=shape.name, number=number, label=FieldDescriptorProto.LABEL_OPTIONAL)
        if shape.repeated:
            field.label = FieldDescriptorProto.LABEL_REPEATED
        if shape.nested:
            field.type = FieldDescriptorProto.TYPE_MESSAGE
            field.type_name = f".{PACKAGE}.{shape.kind.__name__}"
        else:
            field.type = SCALARS[shape.kind]
            if shape.optional:
                # proto3 keeps "is it there" of a scalar in a oneof of its own
                field.proto3_optional = True
                field.oneof_index = len(message.oneof_decl)
                message.oneof_decl.add(name=f"_{shape.name}")
    return message


def proto_text(records: Sequence[type]) -> str:
    """Return the same file in the protobuf language, for readers in other languages."""
    head = 'syntax = "proto3";\n\npackage topomap;\n'
    return head + "".join(f"\n{_message_text(record)}" for record in records)


def _message_text(record: type) -> str:
    names = {bool: "bool", int: "int64", float: "double", str: "string"}
    lines = []
    for number, shape in enumerate(shapes(record), start=1):
        label = "repeated " if shape.repeated else "optional " if shape.optional and not shape.nested else ""
        lines.append(f"  {label}{names.get(shape.kind, shape.kind.__name__)} {shape.name} = {number};\n")
    doc = (record.__doc__ or "").split("\n")[0]
    return f"// {doc}\nmessage {record.__name__} {{\n{''.join(lines)}}}\n"
