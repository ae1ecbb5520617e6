"""What the node uses of rclpy and of message types, without ROS; the signatures are those of rclpy."""

import math
import sys
from types import ModuleType, SimpleNamespace

from dwmr.core.geometry import quaternion

#: A safety filter, as lines of a scenario.
FILTER = (
    *("alpha = 2.0", "lookahead = 0.3", "margin = 0.05", "velocity_error = 0.1"),
    *("acceleration = 2.0", "angular_acceleration = 4.0"),
)


def vector(**more):
    return SimpleNamespace(x=0.0, y=0.0, z=0.0, **more)


class Twist:
    """geometry_msgs/Twist with its defaults."""

    def __init__(self):
        self.linear, self.angular = vector(), vector()


class TwistStamped:
    """geometry_msgs/TwistStamped with its defaults."""

    def __init__(self):
        self.header = SimpleNamespace(stamp=SimpleNamespace(sec=0, nanosec=0), frame_id="")
        self.twist = Twist()


class Odometry:
    """nav_msgs/Odometry with its defaults, but for the covariances."""

    def __init__(self):
        self.header = SimpleNamespace(stamp=SimpleNamespace(sec=0, nanosec=0), frame_id="")
        self.child_frame_id = ""
        self.pose = SimpleNamespace(pose=SimpleNamespace(position=vector(), orientation=vector(w=1.0)))
        self.twist = SimpleNamespace(twist=Twist())


def odometry(t, x, y, theta, v=0.0, omega=0.0, frame="odom", child="base_link", v_y=0.0):
    """A message about the middle of a wheel axis at a time [s]."""
    one = Odometry()
    one.header.stamp.sec, one.header.stamp.nanosec = divmod(round(1e9 * t), 1_000_000_000)
    one.header.frame_id, one.child_frame_id = frame, child
    one.pose.pose.position.x, one.pose.pose.position.y = x, y
    _, _, one.pose.pose.orientation.z, one.pose.pose.orientation.w = quaternion(theta)
    one.twist.twist.linear.x, one.twist.twist.linear.y, one.twist.twist.angular.z = v, v_y, omega
    return one


class Float64:
    """std_msgs/Float64 with its default."""

    def __init__(self, data=0.0):
        self.data = data


class JointState:
    """sensor_msgs/JointState, as far as it is used here."""

    def __init__(self, position=()):
        self.position, self.name = position, []


class WrongTypeError(Exception):
    """rclpy.exceptions.InvalidParameterTypeException."""


class Node:
    """rclpy.node.Node: keeps what is created, published and logged; its time is `now` [s].

    Args:
        given: Values of parameters, as a file of them gives.
    """

    def __init__(self, **given):
        self.given, self.now, self.destroyed = given, 0.0, False
        self.published, self.logged, self.callbacks, self.timers = {}, [], {}, []
        self.sideways, self.subscribed, self.headers = {}, {}, {}
        self.declared = {**dict.fromkeys(given, False), "use_sim_time": False}  # whether they are read-only

    def get_parameters_by_prefix(self, prefix):
        assert prefix == ""
        return {name: SimpleNamespace(name=name) for name in self.declared}

    def undeclare_parameter(self, name):
        del self.declared[name]

    def declare_parameter(self, name, value=None, descriptor=None, ignore_override=False):
        assert name not in self.declared
        self.declared[name] = descriptor.read_only
        found = self.given.get(name, value)
        if type(found) is not type(value):
            raise WrongTypeError(name)
        return SimpleNamespace(name=name, value=found)

    def create_publisher(self, msg_type, topic, qos_profile, **more):
        sent = self.published.setdefault(topic, [])

        def publish(message):
            assert not self.destroyed
            assert isinstance(message, msg_type)
            if hasattr(message, "header"):
                self.headers.setdefault(topic, []).append((message.header.stamp, message.header.frame_id))
            message = message.twist if msg_type is TwistStamped else message
            if isinstance(message, Twist):
                sent.append((message.linear.x, message.angular.z))
                self.sideways.setdefault(topic, []).append(message.linear.y)
            else:
                sent.append(message.data)

        return SimpleNamespace(publish=publish)

    def create_subscription(self, msg_type, topic, callback, qos_profile, **more):
        assert qos_profile == "sensor data"
        self.subscribed[topic] = msg_type
        self.callbacks[topic] = callback

    def create_timer(self, timer_period_sec, callback, *more):
        self.timers.append((timer_period_sec, callback))

    def get_clock(self):
        now = round(1e9 * self.now)
        return SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=now, to_msg=lambda: divmod(now, 1_000_000_000)))

    def get_logger(self):
        def log(severity):
            return lambda message: self.logged.append((severity, message))

        return SimpleNamespace(info=log("info"), warning=log("warning"), error=log("error"))

    def destroy_node(self):
        self.destroyed = True


def install(monkeypatch, node, between=lambda node: None, unknown=()):
    """Put the modules in place; an executor calls `between`, then each timer, and the time goes on by its period.

    Args:
        unknown: Arguments of the program that are not those of ROS.

    Returns:
        What was called of rclpy, in order.
    """
    calls = []

    class SingleThreadedExecutor:
        def add_node(self, one):
            assert one is node

        def spin_once(self, timeout_sec=None):
            between(node)
            for period, callback in node.timers:
                callback()
                node.now += period

    def create_node(node_name, *, automatically_declare_parameters_from_overrides=False):
        assert automatically_declare_parameters_from_overrides
        calls.append(("create_node", node_name))
        return node

    modules = {
        "rclpy": {
            "init": lambda *, args=None, context=None, domain_id=None, signal_handler_options=None: calls.append(
                ("init", signal_handler_options)
            ),
            "create_node": create_node,
            "shutdown": lambda: calls.append(("shutdown", node.destroyed)),
        },
        "rclpy.signals": {"SignalHandlerOptions": SimpleNamespace(NO="no handlers")},
        "rclpy.utilities": {"remove_ros_args": lambda args=None: ["node", *unknown]},
        "rcl_interfaces.msg": {"ParameterDescriptor": SimpleNamespace},
        "rclpy.qos": {"qos_profile_sensor_data": "sensor data"},
        "rclpy.executors": {"SingleThreadedExecutor": SingleThreadedExecutor},
        "rclpy.exceptions": {"InvalidParameterTypeException": WrongTypeError},
        "nav_msgs.msg": {"Odometry": Odometry},
        "geometry_msgs.msg": {"Twist": Twist, "TwistStamped": TwistStamped},
        "std_msgs.msg": {"Float64": Float64},
        "sensor_msgs.msg": {"JointState": JointState},
    }
    for name, content in modules.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    for name in ("nav_msgs", "geometry_msgs", "rcl_interfaces", "std_msgs", "sensor_msgs"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    return calls


class Unicycles:
    """Robots without inertia: their odometry, and their motion under the last commands.

    Args:
        robots: Postures of their wheel axes by name [m, m, rad].
    """

    def __init__(self, robots):
        self.postures = {name: list(posture) for name, posture in robots.items()}

    def report(self, node):
        """Move for a period under the last commands, and publish odometry."""
        for name, posture in self.postures.items():
            sent = node.published[f"{name}/cmd_vel"]
            v, omega = sent[-1] if sent else (0.0, 0.0)
            dt = node.timers[0][0] if sent else 0.0
            posture[0] += dt * v * math.cos(posture[2] + 0.5 * dt * omega)
            posture[1] += dt * v * math.sin(posture[2] + 0.5 * dt * omega)
            posture[2] += dt * omega
            node.callbacks[f"{name}/odom"](odometry(node.now, *posture, v, omega))
