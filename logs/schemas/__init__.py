"""Records as protobuf: the dataclasses are the schema, `topomap.proto` shows it to other languages."""
