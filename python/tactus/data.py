"""Data sets, one grasp at a time."""

from __future__ import annotations

import logging
import operator
import os
from typing import Iterator, Literal, SupportsIndex, TypedDict, cast, overload

from . import _tactus
from .meshes import F32, F64, Pad, Surface


class StoredGrasp(TypedDict):
    """Grasp of a data set; nodal fields in the pad frames. `F` frames, `P` pads, left first, `n` nodes per pad.

    object: name of the object.
    grasp: index of the grasp.
    displacement_m: (F, P, n, 3), m.
    contact_force_n: (F, P, n, 3), N, on the pad.
    von_mises_pa: (F, P, n), Pa.
    force_n: (F), N, sum over the fingers of |normal force|.
    travel_m: (F, P), m, closing travel of each finger since first contact.
    finger_position_m: (F, P), m, closing travel of each finger from the open hand.
    object_pose: (F, 7), m and 1, pose of the object in the hand frame.
    object_load: (F, 6), N and N m, external load on the object (weight and applied push), hand axes.
    wrench: (F, P, 6), N and N m, contact force and torque on each pad.
    grasp_pose: (7), m and 1, initial pose of the hand in the object frame.
    tactile: arrays of the recorded tactile sensors by name: (F, P, ...).
    """

    object: str
    grasp: int
    displacement_m: F32
    contact_force_n: F32
    von_mises_pa: F32
    force_n: F64
    travel_m: F64
    finger_position_m: F64
    object_pose: F64
    object_load: F64
    wrench: F64
    grasp_pose: F64
    tactile: dict[str, F32]


class DataSet:
    """Data set written by `tactus dataset`: the sequence of its grasps that reached their load, read on demand.

    folder: folder of the data set.
    part: `"all"`, or the `"train"` or `"test"` set of its split by poses.

    It is a map-style `torch.utils.data.Dataset`, so it can be used with a `DataLoader`, also with workers. A slice,
    e.g. `data[:100]`, is a `DataSet` of those grasps and reads no data; `data["lemon", 3]` is a grasp by object and
    index. Copies and pickles store the folder and reopen it. Objects whose files were modified or damaged are excluded
    with a warning to the logger `tactus`. Raises ValueError if there is no finished data set, FileNotFoundError if the
    folder does not exist.
    """

    def __init__(self, folder: str | os.PathLike[str], part: Literal["all", "train", "test"] = "all") -> None:
        if part not in ("all", "train", "test"):
            raise ValueError(f'part {part!r}; allowed: "all", "train", "test"')
        self.folder = os.path.abspath(folder)
        self.part = part
        self._open()
        for damage in self.damaged():
            logging.getLogger("tactus").warning("omitted: %s", damage)
        if part == "all":
            self._chosen = [(name, grasp) for name, reached in self._reached.items() for grasp in reached]
        else:
            self._chosen = self.split(test=part == "test")

    def _open(self) -> None:
        self._files, self._process = _tactus.Files(self.folder), os.getpid()
        self._reached = {name: reached for name, _, reached in self._files.objects()}

    def _own(self) -> _tactus.Files:
        # A forked process would share the positions of open files with its parent.
        if self._process != os.getpid():
            self._open()
        return self._files

    def __len__(self) -> int:
        return len(self._chosen)

    @overload
    def __getitem__(self, index: SupportsIndex | tuple[str, int]) -> StoredGrasp: ...
    @overload
    def __getitem__(self, index: slice) -> DataSet: ...
    def __getitem__(self, index: SupportsIndex | tuple[str, int] | slice) -> StoredGrasp | DataSet:
        match index:
            case slice():
                some = DataSet.__new__(DataSet)
                some.__dict__ |= self.__dict__ | {"_chosen": self._chosen[index]}
                return some
            case (str() as object, SupportsIndex() as grasp):
                return self.grasp(object, operator.index(grasp))
            case SupportsIndex():
                return self.grasp(*self._chosen[index])
        found = type(index).__name__
        raise TypeError(f"a data set is indexed by an integer, a slice, or (object, grasp) like data['lemon', 3], not by {found}")

    def __iter__(self) -> Iterator[StoredGrasp]:
        return (self[index] for index in range(len(self)))

    def __reduce__(self) -> tuple[type[DataSet], tuple[str, str], list[tuple[str, int]]]:
        return DataSet, (self.folder, self.part), self._chosen

    def __setstate__(self, chosen: list[tuple[str, int]]) -> None:
        self._chosen = chosen

    def __repr__(self) -> str:
        return f"DataSet({self.folder!r}, {self.part!r}): {len(self)} grasps of {len(self._reached)} objects"

    def damaged(self) -> list[str]:
        """Returns the reasons why objects are excluded, one sentence each."""
        return self._files.damaged()

    def objects(self) -> list[str]:
        """Returns the names of the objects."""
        return list(self._reached)

    def reached(self, object: str) -> list[int]:
        """Returns the indices of the grasps of an object that reached their load. Like the methods below it raises
        ValueError if the object does not exist."""
        if object not in self._reached:
            raise ValueError(f"the data set has no object {object!r}; it has: {', '.join(self._reached)}")
        return self._reached[object]

    def split(self, test: bool) -> list[tuple[str, int]]:
        """Returns (object, grasp) of the training or the test set of the split by poses."""
        return self._files.split(test)

    def grasp(self, object: str, grasp: int) -> StoredGrasp:
        """Returns the arrays of a grasp. Raises ValueError also if its data is damaged."""
        arrays = self._own().grasp(object, grasp)
        return cast(StoredGrasp, {"object": object, "grasp": grasp, **arrays})

    def pads(self, object: str) -> tuple[Pad, ...]:
        """Returns the reference meshes of the pads for an object, left first."""
        return tuple(Pad(**pad) for pad in self._files.pads(object))

    def surface(self, object: str) -> Surface:
        """Returns the surface of an object."""
        return Surface(**self._files.surface(object))

    def scene(self, object: str) -> str:
        """Returns the scene of an object as RON with all defaults written out."""
        return self._files.scene(object)
