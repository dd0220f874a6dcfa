"""Planning: parts and a machine in, a `Plan` out, or every reason why there is none."""

from beamcam.planning.beam import Order, plan_bar
from beamcam.planning.rules import SKIP_NAMES

__all__ = ["SKIP_NAMES", "Order", "plan_bar"]
