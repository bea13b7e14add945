"""ROS 2 node: publishes the load and the taxels of each finger, and events as text.

Run it in an environment with ROS 2 and this package: python tactile_node.py /dev/ttyACM0 hand.toml
"""

import sys
from threading import Thread

import numpy as np
import rclpy  # type: ignore[import-not-found]  # part of ROS 2
from geometry_msgs.msg import WrenchStamped  # type: ignore[import-not-found]  # the same
from rclpy.node import Node  # type: ignore[import-not-found]  # the same
from rclpy.time import Time  # type: ignore[import-not-found]  # the same
from sensor_msgs.msg import PointCloud2, PointField  # type: ignore[import-not-found]  # the same
from std_msgs.msg import String  # type: ignore[import-not-found]  # the same

import tactile

FIELDS = ("x", "y", "z", "shear_x", "shear_y", "normal")


class TactileNode(Node):  # type: ignore[misc]  # its class is unknown without ROS 2
    """Publishes /tactile/NAME/wrench, /tactile/NAME/taxels and /tactile/events."""

    def __init__(self, frames: tactile.Stream) -> None:
        super().__init__("tactile")
        self.places = {array.name: array.positions() for array in frames.arrays}
        self.wrench = {
            name: self.create_publisher(WrenchStamped, f"/tactile/{name}/wrench", 10) for name in self.places
        }
        self.taxels = {name: self.create_publisher(PointCloud2, f"/tactile/{name}/taxels", 10) for name in self.places}
        self.events = self.create_publisher(String, "/tactile/events", 10)

    def publish(self, frame: tactile.StreamFrame) -> None:
        """Publish one frame."""
        wrench, cloud, name = WrenchStamped(), PointCloud2(), frame.finger
        cloud.header.stamp = wrench.header.stamp = Time(nanoseconds=int(frame.unix_s * 1e9)).to_msg()
        cloud.header.frame_id = wrench.header.frame_id = name
        load = np.nan_to_num([frame.load.Q, frame.load.R, frame.load.F]).tolist()
        wrench.wrench.force.x, wrench.wrench.force.y, wrench.wrench.force.z = load
        self.wrench[name].publish(wrench)
        height = np.zeros((*frame.valid.shape, 1))
        points = np.concatenate((self.places[name], height, frame.values), -1).astype("<f4")
        cloud.height, cloud.width, cloud.point_step = *frame.valid.shape, points[0, 0].nbytes
        cloud.row_step, cloud.data = points[0].nbytes, points.tobytes()
        cloud.fields = [PointField(name=one, offset=4 * n, datatype=7, count=1) for n, one in enumerate(FIELDS)]
        self.taxels[name].publish(cloud)
        for event in frame.begun:
            self.events.publish(String(data=f"{event.finger}: {event.words}"))


def main() -> None:
    """Publish the frames of a port until it is closed or Ctrl-C."""
    rclpy.init()
    port, array = (*sys.argv[1:], None)[:2]
    assert port is not None, "python tactile_node.py PORT ARRAY.toml"
    with tactile.stream(port, array) as frames:
        node = TactileNode(frames)
        Thread(target=rclpy.spin, args=(node,), daemon=True).start()
        for frame in frames:
            node.publish(frame)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
