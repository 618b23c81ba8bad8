"""The whole-body controller: SEIKO Retargeting, contact switching, and the 500 Hz loop around them.

Equations are those of Rouxel et al., "SEIKO" (IEEE/ASME T-Mech 2022, Retargeting; IEEE RA-L 2024,
arXiv 2312.16465), in Pinocchio's conventions: base twist in the base frame, linear then angular;
wrenches force then torque.
"""
