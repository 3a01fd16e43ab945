"""LeRobot's errors about devices."""


class DeviceNotConnectedError(ConnectionError):
    """The device is used before it is connected."""


class DeviceAlreadyConnectedError(ConnectionError):
    """The device is connected twice."""
