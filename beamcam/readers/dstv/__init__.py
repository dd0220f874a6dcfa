"""The DSTV reader (.nc, .nc1): 7th edition of the standard, and what real files make of it."""

from beamcam.readers.dstv.reader import Account, looks_like, read, read_with_account
from beamcam.readers.dstv.rules import RULES

__all__ = ["RULES", "Account", "looks_like", "read", "read_with_account"]
