"""The driver library of CUDA, by ctypes: memory, copies, kernels. To import this no CUDA is needed."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import sys
import threading
import weakref
from collections.abc import Callable, Iterator
from typing import Any

from neve.cuda.errors import OUT_OF_MEMORY, DriverError, NoDevice, NoSuchDevice

LIBRARY = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"
"""What the driver of the GPU installs; no wheel brings it."""

_MAJOR, _MINOR = 75, 76  # CUdevice_attribute: of the compute capability
_RELAXED = 2  # CUstreamCaptureMode: other threads may go on meanwhile
_WITHOUT_TIME, _BESIDE = 2, 1  # CU_EVENT_DISABLE_TIMING, CU_STREAM_NON_BLOCKING
_here = threading.local()
"""The context that each thread of the host has said it means."""


class Driver:
    """A GPU, as the driver library gives it.

    Addresses are whole numbers. Calls follow one another on one stream, but for those inside `on`; a kernel
    that fails is told of by a later call. Errors: DriverError in all methods.

    Attributes:
        number: of the GPU, from 0 on; name: of the GPU
        architecture: 90 for compute capability 9.0
        version: of the CUDA that the driver knows, (13, 1)
    """

    def __init__(self, number: int = 0, library: str = LIBRARY) -> None:
        """Open the library and the GPU. Errors: NoDevice if there is none, NoSuchDevice for its number."""
        self.number = number
        self._thread, self._context = threading.local(), ctypes.c_void_p()
        try:
            self._library = ctypes.CDLL(library)
        except OSError:
            raise NoDevice(f"there is no driver of NVIDIA ({library} is not installed)") from None
        try:
            self._open()
        except DriverError as error:
            raise NoDevice(f"the driver of NVIDIA finds no GPU ({error.name})") from None

    def _open(self) -> None:
        self._call("cuInit", ctypes.c_uint(0))
        number, device, context = ctypes.c_int(), ctypes.c_int(), ctypes.c_void_p()
        self._call("cuDriverGetVersion", ctypes.byref(number))
        self.version = (number.value // 1000, number.value % 1000 // 10)
        count = self._count()
        if self.number >= max(count, 1):
            raise NoSuchDevice(self.number, count)
        self._call("cuDeviceGet", ctypes.byref(device), ctypes.c_int(self.number))
        self.name = self._name(device)
        self._device = device
        self.architecture = 10 * self.attribute(_MAJOR) + self.attribute(_MINOR)
        self._call("cuDevicePrimaryCtxRetain", ctypes.byref(context), device)
        self._context = context

    def _name(self, device: ctypes.c_int) -> str:
        name = ctypes.create_string_buffer(256)
        self._call("cuDeviceGetName", name, ctypes.c_int(len(name)), device)
        return name.value.decode(errors="replace")

    def attribute(self, which: int) -> int:
        """Return a CUdevice_attribute of the GPU."""
        return self._attribute(which, self._device)

    def _attribute(self, which: int, device: ctypes.c_int) -> int:
        value = ctypes.c_int()
        self._call("cuDeviceGetAttribute", ctypes.byref(value), ctypes.c_int(which), device)
        return value.value

    def _call(self, function: str, *arguments: Any) -> None:
        if self._context and getattr(_here, "context", None) is not self._context:
            _here.context = self._context  # each thread of the host says which GPU it means
            self._call("cuCtxSetCurrent", self._context)
        code = getattr(self._library, function)(*arguments)
        if code != 0:
            name = ctypes.c_char_p()
            self._library.cuGetErrorName(ctypes.c_int(code), ctypes.byref(name))
            raise DriverError(name.value.decode() if name.value else f"CUDA error {code}")

    def devices(self) -> list[dict[str, Any]]:
        """Return of each GPU its name, its compute capability, such as "9.0", and its memory [bytes]."""
        out = []
        for i in range(self._count()):
            device, memory = ctypes.c_int(), ctypes.c_size_t()
            self._call("cuDeviceGet", ctypes.byref(device), ctypes.c_int(i))
            self._call("cuDeviceTotalMem_v2", ctypes.byref(memory), device)
            capability = f"{self._attribute(_MAJOR, device)}.{self._attribute(_MINOR, device)}"
            out.append({"name": self._name(device), "compute_capability": capability, "memory": memory.value})
        return out

    def _count(self) -> int:
        count = ctypes.c_int()
        self._call("cuDeviceGetCount", ctypes.byref(count))
        return count.value

    # Memory

    def memory(self) -> tuple[int, int]:
        """Return how many bytes are free, and how many there are."""
        free, total = ctypes.c_size_t(), ctypes.c_size_t()
        self._call("cuMemGetInfo_v2", ctypes.byref(free), ctypes.byref(total))
        return free.value, total.value

    def allocate(self, size: int) -> int:
        """Return the address of `size` bytes, of any content; never more than are free."""
        if size > self.memory()[0]:
            raise DriverError(OUT_OF_MEMORY)
        address = ctypes.c_uint64()
        self._call("cuMemAlloc_v2", ctypes.byref(address), ctypes.c_size_t(max(size, 1)))
        return address.value

    def free(self, address: int) -> None:
        """Give back what `allocate` returned."""
        self._call("cuMemFree_v2", ctypes.c_uint64(address))

    def upload(self, address: int, source: int | bytes, size: int) -> None:
        """Copy `size` bytes to the GPU; source: an address here, or bytes."""
        self._call("cuMemcpyHtoD_v2", ctypes.c_uint64(address), _pointer(source), ctypes.c_size_t(size))

    def download(self, target: int, address: int, size: int) -> None:
        """Copy `size` bytes from the GPU to an address here, when all before it is done."""
        self._call(
            "cuMemcpyDtoH_v2", ctypes.c_void_p(target), ctypes.c_uint64(address), ctypes.c_size_t(size)
        )

    def fill(self, address: int, byte: int, size: int) -> None:
        """Set `size` bytes."""
        if size:
            self._call("cuMemsetD8_v2", ctypes.c_uint64(address), ctypes.c_ubyte(byte), ctypes.c_size_t(size))

    def copy(self, target: int, source: int, size: int) -> None:
        """Copy `size` bytes from one place on the GPU to another."""
        if size:
            self._call(
                "cuMemcpyDtoD_v2", ctypes.c_uint64(target), ctypes.c_uint64(source), ctypes.c_size_t(size)
            )

    def send(self, receiver: Driver, target: int, source: int, size: int, lane: ctypes.c_void_p) -> None:
        """Copy `size` bytes to another GPU, or to this one, in turn with what is on the stream `lane`."""
        there, here, length = ctypes.c_uint64(target), ctypes.c_uint64(source), ctypes.c_size_t(size)
        if size and receiver is self:
            self._call("cuMemcpyDtoDAsync_v2", there, here, length, lane)
        elif size:
            self._call("cuMemcpyPeerAsync", there, receiver._context, here, self._context, length, lane)

    def meet(self, other: Driver) -> None:
        """Let copies between this GPU and another go the direct way, if there is one."""
        can = ctypes.c_int()
        self._call("cuDeviceCanAccessPeer", ctypes.byref(can), self._device, other._device)
        if can.value:
            with contextlib.suppress(DriverError):  # of GPUs that have met before
                self._call("cuCtxEnablePeerAccess", other._context, ctypes.c_uint(0))

    # Streams

    def lane(self) -> ctypes.c_void_p:
        """Return a new stream, which runs beside the usual one and all others."""
        made = ctypes.c_void_p()
        self._call("cuStreamCreate", ctypes.byref(made), ctypes.c_uint(_BESIDE))
        return made

    def destroy_lane(self, lane: ctypes.c_void_p) -> None:
        """Give a stream back."""
        self._call("cuStreamDestroy_v2", lane)

    @contextlib.contextmanager
    def on(self, lane: ctypes.c_void_p) -> Iterator[None]:
        """Start the kernels of the `with` block, those of this thread of the host, on the stream `lane`."""
        self._thread.lane = lane
        try:
            yield
        finally:
            self._thread.lane = None

    def fence(self) -> ctypes.c_void_p:
        """Return a mark that can be set in a stream, for others to wait for."""
        made = ctypes.c_void_p()
        self._call("cuEventCreate", ctypes.byref(made), ctypes.c_uint(_WITHOUT_TIME))
        return made

    def destroy_fence(self, fence: ctypes.c_void_p) -> None:
        """Give a mark back."""
        self._call("cuEventDestroy_v2", fence)

    def set_fence(self, fence: ctypes.c_void_p, lane: ctypes.c_void_p | None = None) -> None:
        """Set a mark after all that is on the stream `lane` now; None: on the usual one."""
        self._call("cuEventRecord", fence, lane)

    def wait_for(self, fence: ctypes.c_void_p, lane: ctypes.c_void_p | None = None) -> None:
        """Let what comes next on the stream `lane` wait for a mark, of this GPU or another."""
        self._call("cuStreamWaitEvent", lane, fence, ctypes.c_uint(0))

    # Kernels

    def load(self, image: bytes) -> Module:
        """Load compiled kernels."""
        module = ctypes.c_void_p()
        self._call("cuModuleLoadData", ctypes.byref(module), ctypes.c_char_p(image))
        return Module(self, module)

    def function(self, module: ctypes.c_void_p, name: str) -> ctypes.c_void_p:
        """Return a kernel of a module."""
        found = ctypes.c_void_p()
        self._call("cuModuleGetFunction", ctypes.byref(found), module, ctypes.c_char_p(name.encode()))
        return found

    def launch(self, function: ctypes.c_void_p, blocks: int, threads: int, step: ctypes.Structure) -> None:
        """Start a kernel whose one argument is `step`."""
        if not blocks:
            return
        arguments = (ctypes.c_void_p * 1)(ctypes.addressof(step))
        one, none = ctypes.c_uint(1), ctypes.c_uint(0)
        grid = (ctypes.c_uint(blocks), one, one, ctypes.c_uint(threads), one, one)
        lane = getattr(self._thread, "lane", None)
        self._call("cuLaunchKernel", function, *grid, none, lane, arguments, None)

    def captured(self, launches: Callable[[], None]) -> Graph | None:
        """Return what `launches` would start, to be started at once; None if the driver is too old for it."""
        if not hasattr(self._library, "cuGraphInstantiateWithFlags"):  # of CUDA 11.4
            return None
        stream, graph, ready = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_void_p()
        self._call("cuStreamCreate", ctypes.byref(stream), ctypes.c_uint(0))
        try:
            self._call("cuStreamBeginCapture_v2", stream, ctypes.c_int(_RELAXED))
            try:
                with self.on(stream):
                    launches()
            finally:
                self._call("cuStreamEndCapture", stream, ctypes.byref(graph))
            self._call("cuGraphInstantiateWithFlags", ctypes.byref(ready), graph, ctypes.c_ulonglong(0))
            self._call("cuGraphDestroy", graph)
        finally:
            self._call("cuStreamDestroy_v2", stream)
        return Graph(self, ready)

    def launch_graph(self, graph: ctypes.c_void_p) -> None:
        """Start all that was captured."""
        self._call("cuGraphLaunch", graph, None)

    def destroy_graph(self, graph: ctypes.c_void_p) -> None:
        """Forget what was captured."""
        self._call("cuGraphExecDestroy", graph)

    def synchronize(self) -> None:
        """Wait until all is done."""
        self._call("cuCtxSynchronize")

    # Time

    def event(self) -> ctypes.c_void_p:
        """Return a mark in the stream, set now."""
        made = ctypes.c_void_p()
        self._call("cuEventCreate", ctypes.byref(made), ctypes.c_uint(0))
        self._call("cuEventRecord", made, None)
        return made

    def milliseconds(self, first: ctypes.c_void_p, last: ctypes.c_void_p) -> float:
        """Return the time between two marks [ms], waiting for the last."""
        out = ctypes.c_float()
        self._call("cuEventSynchronize", last)
        self._call("cuEventElapsedTime", ctypes.byref(out), first, last)
        return out.value


class Graph:
    """Launches that are started at once."""

    def __init__(self, driver: Driver, graph: ctypes.c_void_p) -> None:
        self._driver, self._graph = driver, graph
        weakref.finalize(self, _forget, driver, graph)

    def launch(self) -> None:
        """Start them. Errors: DriverError."""
        self._driver.launch_graph(self._graph)


def _forget(driver: Driver, graph: ctypes.c_void_p) -> None:
    with contextlib.suppress(DriverError):  # after a kernel has failed nothing can be given back
        driver.destroy_graph(graph)


class Module:
    """Kernels of one compilation, by name."""

    def __init__(self, driver: Driver, module: ctypes.c_void_p) -> None:
        self._driver, self._module = driver, module
        self._functions: dict[str, ctypes.c_void_p] = {}

    def __getitem__(self, name: str) -> ctypes.c_void_p:
        if name not in self._functions:
            self._functions[name] = self._driver.function(self._module, f"neve_{name}")
        return self._functions[name]


def _pointer(source: int | bytes) -> Any:
    return ctypes.c_char_p(source) if isinstance(source, bytes) else ctypes.c_void_p(source)


@functools.cache
def driver(number: int = 0) -> Driver:
    """Return a GPU of this process. Errors: NoDevice, NoSuchDevice."""
    return Driver(number)
