"""A folder that holds a drive: `drive.csv`, `rig.json` and the panoramas that both speak of.

`drive.csv` has one line a reading, in the order of time, under a header that names its columns:

    stamp_s                                     run time [s], later on every line
    image                                       file of the panorama (PNG or JPEG), relative to the folder
    forward_m, turn_rad [, left_m]              odometry since the line before, or
    odom_x_m, odom_y_m, odom_heading_rad        odometry summed up, as the odometer has it
    forward_sigma_m, left_sigma_m, turn_sigma_rad   errors of the increment, where the driver tells any
    x_m, y_m [, heading_rad]                    where the robot was (counter-clockwise from +x)

Where there is odometry, x_m, y_m and heading_rad are the truth: it goes to the metrics and never to the stack. Where
there is none, they are taken for the odometer's own poses, and nothing is known of the truth. `rig.json` holds
width, height, horizon_row, camera_height [m], forward_column and clockwise; what it leaves out is told by
`topomap.datasets.drive_folder.rig_file`.
"""

from topomap.datasets.drive_folder.reader import DriveFolder, read_folder
from topomap.datasets.drive_folder.robot import FolderRobot
from topomap.datasets.drive_folder.table import DriveTable

__all__ = ["DriveFolder", "DriveTable", "FolderRobot", "read_folder"]
