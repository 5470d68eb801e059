"""The ground that every wing stands on.

Arrays, plane geometry (`Pose2`), records, errors, `Rig`, `Panorama`, the Protocols of a robot, `RunData`.
"""
