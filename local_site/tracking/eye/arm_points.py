"""The points of an arm that the networks find: their order, and the lengths between them that no posture changes."""

import numpy as np

# The elbow, then the hand's 21 landmarks in the published order: wrist, thumb from its base to its tip, then index,
# middle, ring and little finger from the knuckle to the tip, which lies on the skin.
ELBOW, WRIST, THUMB_BASE, THUMB_TIP = 0, 1, 2, 5
INDEX_KNUCKLE, INDEX_TIP, MIDDLE_KNUCKLE, RING_KNUCKLE, LITTLE_KNUCKLE = 6, 9, 10, 14, 18
POINTS = 22
PALM = (WRIST, INDEX_KNUCKLE, MIDDLE_KNUCKLE, RING_KNUCKLE, LITTLE_KNUCKLE)
KNUCKLES = (INDEX_KNUCKLE, MIDDLE_KNUCKLE, LITTLE_KNUCKLE)  # whose middle is that of the hand's crop
FINGERS = (INDEX_KNUCKLE, MIDDLE_KNUCKLE, RING_KNUCKLE, LITTLE_KNUCKLE)

_LENGTHS_MM = {
    (ELBOW, WRIST): 257.0,
    (WRIST, THUMB_BASE): 46.8,
    (2, 3): 32.9,
    (3, 4): 38.7,
    (4, 5): 30.9,
    (WRIST, INDEX_KNUCKLE): 111.3,
    (6, 7): 27.6,
    (7, 8): 24.6,
    (8, 9): 28.2,
    (WRIST, MIDDLE_KNUCKLE): 107.0,
    (10, 11): 36.0,
    (11, 12): 29.3,
    (12, 13): 27.1,
    (WRIST, RING_KNUCKLE): 103.0,
    (14, 15): 31.7,
    (15, 16): 26.4,
    (16, 17): 28.9,
    (WRIST, LITTLE_KNUCKLE): 99.4,
    (18, 19): 22.6,
    (19, 20): 16.7,
    (20, 21): 21.5,
    (INDEX_KNUCKLE, MIDDLE_KNUCKLE): 27.7,
    (MIDDLE_KNUCKLE, RING_KNUCKLE): 21.1,
    (RING_KNUCKLE, LITTLE_KNUCKLE): 22.4,
    (INDEX_KNUCKLE, LITTLE_KNUCKLE): 68.9,
    (THUMB_BASE, INDEX_KNUCKLE): 68.8,
    (THUMB_BASE, MIDDLE_KNUCKLE): 72.8,
}
BONES = np.array(list(_LENGTHS_MM), dtype=np.intp)  # (27, 2)
AVERAGE_M = 1e-3 * np.array(list(_LENGTHS_MM.values()))
SPREAD = 0.13  # of the lengths of bodies, each against its mean
