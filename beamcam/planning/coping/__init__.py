"""The work of a torch that goes round a profile: what is cut of each wall, how and in which order.

part -> a region of each wall that stays (regions) -> corners rounded, half a kerf off, clipped to
where the torch comes (walls) -> cuts with their leads (cuts) -> in order, with a ledger (plan)
"""
