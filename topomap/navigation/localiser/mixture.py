"""Several Gaussian hypotheses of one pose, and the probability that none of them holds."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, compose, wrap_all
from topomap.core.records import Motion

MOST = 256
"""Hypotheses that are kept, the likeliest: in `office-loop` every door is one, in both directions."""
LEAST = -14.0
"""Log of the probability below which one is dropped."""
SAME, SAME_TURN = 0.6, 0.6
"""Poses as near as this [m], [rad] are one hypothesis: over it a view changes less than from one place to the next."""


@dataclass(frozen=True, slots=True, eq=False)
class Mixture:
    """n hypotheses: poses (n, 3), covariances (n, 3, 3) in the map frame, log weights (n,); seen (n, 3): over the last
    stretch the sum of squared likenesses, how many looks, and the least one; behind (n,): how far each was behind the
    most alike one over a stretch, at most of late. elsewhere: log weight of all that isn't among them.
    """

    poses: FloatArray
    covariances: FloatArray
    weights: FloatArray
    seen: FloatArray
    behind: FloatArray
    elsewhere: float

    def __len__(self) -> int:
        return len(self.weights)

    @staticmethod
    def unknown() -> Mixture:
        """Return that nothing is known."""
        return Mixture(np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0), np.zeros((0, 3)), np.zeros(0), 0.0)

    @staticmethod
    def at(pose: FloatArray, covariance: FloatArray, doubt: float) -> Mixture:
        """Return one hypothesis, which doesn't hold with a probability of `doubt`."""
        return Mixture(
            pose[None].copy(),
            covariance[None].copy(),
            np.log([1.0 - doubt]),
            unseen(1),
            np.zeros(1),
            float(np.log(doubt)),
        )

    def moved(self, motion: Motion, noise: FloatArray) -> Mixture:
        """Return all hypotheses after a (corrected) motion with its covariance `noise` (3, 3) in the robot frame."""
        half = self.poses[:, 2] + motion.turn / 2
        c, s = np.cos(half), np.sin(half)
        x = c * motion.forward - s * motion.left
        y = s * motion.forward + c * motion.left
        poses = self.poses + np.stack([x, y, np.full(len(self), motion.turn)], axis=-1)
        poses[:, 2] = wrap_all(poses[:, 2])
        jacobian = np.tile(np.eye(3), (len(self), 1, 1))
        jacobian[:, 0, 2], jacobian[:, 1, 2] = -y, x
        turn = _turned(self.poses[:, 2])
        covariances = jacobian @ self.covariances @ jacobian.transpose(0, 2, 1) + turn @ noise @ turn.transpose(0, 2, 1)
        return replace(self, poses=poses, covariances=covariances)

    def carried(self, nodes: IntArray, before: FloatArray, after: FloatArray) -> Mixture:
        """Return the hypotheses carried along with the nodes (n,) they are near, whose poses (N, 3) the map moved."""
        if not len(self):
            return self
        return replace(self, poses=compose(after[nodes], between(before[nodes], self.poses)))

    def measured(self, which: IntArray, poses: FloatArray, covariances: FloatArray) -> Mixture:
        """Return hypotheses `which` (k,) corrected by measured poses (k, 3) with covariances (k, 3, 3)."""
        if not len(which):
            return self
        prior = self.covariances[which]
        gain = prior @ np.linalg.inv(prior + covariances)
        off = poses - self.poses[which]
        off[:, 2] = wrap_all(off[:, 2])
        new, spread = self.poses.copy(), self.covariances.copy()
        new[which] += (gain @ off[:, :, None])[:, :, 0]
        new[:, 2] = wrap_all(new[:, 2])
        spread[which] = (np.eye(3) - gain) @ prior
        return replace(self, poses=new, covariances=0.5 * (spread + spread.transpose(0, 2, 1)))

    def joined_by(
        self, poses: FloatArray, covariance: FloatArray, weights: FloatArray, behind: FloatArray | None = None
    ) -> Mixture:
        """Return the mixture with new hypotheses (k, 3) of log weights (k,), each with that covariance (3, 3).

        behind (k,): how far each was behind the most alike one; none: not yet.
        """
        return replace(
            self,
            poses=np.concatenate([self.poses, poses]),
            covariances=np.concatenate([self.covariances, np.broadcast_to(covariance, (len(poses), 3, 3))]),
            weights=np.concatenate([self.weights, weights]),
            seen=np.concatenate([self.seen, unseen(len(poses))]),
            behind=np.concatenate([self.behind, np.zeros(len(poses)) if behind is None else behind]),
        )

    def looked(self, which: IntArray, squares: FloatArray, most: float = np.inf) -> Mixture:
        """Return hypotheses `which` (k,) with a look more, of squared likeness `squares` (k,), of which the sum
        takes no more than `most`.
        """
        seen = self.seen.copy()
        seen[which, 0] += np.minimum(squares, most)
        seen[which, 1] += 1.0
        seen[which, 2] = np.minimum(seen[which, 2], squares)
        return replace(self, seen=seen)

    def tinted(self, which: IntArray, squares: FloatArray) -> Mixture:
        """Return hypotheses `which` (k,) whose last look was so much less alike in colour, squared (k,)."""
        seen = self.seen.copy()
        seen[which, 0] += squares
        return replace(self, seen=seen)

    def weighed(self, ratios: FloatArray, escape: float) -> Mixture:
        """Return the weights times likelihood ratios (n,) in logs; each fails with a probability `escape` first."""
        total = np.logaddexp.reduce(self.weights) if len(self) else -np.inf
        elsewhere = float(np.logaddexp(self.elsewhere, np.log(escape) + total))
        return replace(self, weights=self.weights + np.log1p(-escape) + ratios, elsewhere=elsewhere).normalised()

    def shaken(self, doubt: float) -> Mixture:
        """Return the mixture after something that none of the hypotheses survived with a probability of `doubt`."""
        rest = float(np.logaddexp(self.elsewhere + np.log1p(-doubt), np.log(doubt)))
        count = len(self)
        return replace(
            self, weights=self.weights + np.log1p(-doubt), seen=unseen(count), behind=np.zeros(count), elsewhere=rest
        ).normalised()

    def normalised(self) -> Mixture:
        """Return weights that add up to one."""
        total = float(np.logaddexp.reduce([*self.weights.tolist(), self.elsewhere]))
        return replace(self, weights=self.weights - total, elsewhere=self.elsewhere - total)

    def pruned(self) -> Mixture:
        """Return hypotheses that lie near one another as one, sorted, the unlikely ones given to `elsewhere`."""
        order = np.argsort(-self.weights, kind="stable")
        order = order[self.weights[order] > LEAST]
        alike = self.near(self.poses[order])[:, order]
        weights = self.weights[order].copy()
        keep, taken = list[int](), np.zeros(len(order), bool)
        for k in range(len(order)):
            if taken[k]:
                continue
            if len(keep) == MOST:
                break
            group = alike[k] & ~taken
            weights[k] = np.logaddexp.reduce(weights[group])
            taken |= group
            keep.append(k)
        kept = order[keep]
        return replace(
            self,
            poses=self.poses[kept],
            covariances=self.covariances[kept],
            weights=weights[keep],
            seen=self.seen[kept],
            behind=self.behind[kept],
        ).normalised()

    def near(self, poses: FloatArray, within: float = 0.0) -> BoolArray:
        """Return (k, n) whether poses (k, 3) and the hypotheses are one and the same; within [m]: where that is more
        than what usually counts as the same.
        """
        return same(poses, self.poses, within)


def same(poses: FloatArray, others: FloatArray, within: float = 0.0) -> BoolArray:
    """Return (k, n) whether poses (k, 3) and others (n, 3) are one and the same, as `Mixture.near` does."""
    away = np.hypot(*(poses[:, None, :2] - others[None, :, :2]).transpose(2, 0, 1))
    turned = np.abs(wrap_all(poses[:, None, 2] - others[None, :, 2]))
    found: BoolArray = (away < max(SAME, within)) & (turned < SAME_TURN)
    return found


def unseen(count: int) -> FloatArray:
    """Return the `seen` (count, 3) of hypotheses that had no look yet."""
    return np.tile([0.0, 0.0, np.inf], (count, 1))


def _turned(headings: FloatArray) -> FloatArray:
    """Return (n, 3, 3) rotations of robot-frame increments into the map frame."""
    c, s = np.cos(headings), np.sin(headings)
    turn = np.zeros((len(headings), 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c, -s, s, c, 1.0
    return turn
