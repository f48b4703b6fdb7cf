"""The driver library of CUDA, by ctypes: memory, copies, kernels. To import this no CUDA is needed."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import sys
import threading
import weakref
from collections.abc import Callable
from typing import Any

from neve.cuda.errors import OUT_OF_MEMORY, DriverError, NoDevice

LIBRARY = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"
"""What the driver of the GPU installs; no wheel brings it."""

_MAJOR, _MINOR = 75, 76  # CUdevice_attribute: of the compute capability
_RELAXED = 2  # CUstreamCaptureMode: other threads may go on meanwhile


class Driver:
    """The first GPU, as the driver library gives it.

    Addresses are whole numbers. Calls follow one another on one stream; a kernel that fails is told of by a
    later call. Errors: DriverError in all methods.

    Attributes:
        name: of the GPU; architecture: 90 for compute capability 9.0; version: of the CUDA that the driver
        knows, (13, 1)
    """

    def __init__(self, library: str = LIBRARY) -> None:
        """Open the library and the GPU. Errors: NoDevice."""
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
        self._call("cuDeviceGet", ctypes.byref(device), ctypes.c_int(0))
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
        if self._context and not getattr(self._thread, "has_context", False):
            self._thread.has_context = True  # each thread of the host says that it means this GPU
            self._call("cuCtxSetCurrent", self._context)
        code = getattr(self._library, function)(*arguments)
        if code != 0:
            name = ctypes.c_char_p()
            self._library.cuGetErrorName(ctypes.c_int(code), ctypes.byref(name))
            raise DriverError(name.value.decode() if name.value else f"CUDA error {code}")

    def devices(self) -> list[dict[str, Any]]:
        """Return of each GPU its name, its compute capability, such as "9.0", and its memory [bytes]."""
        count, out = ctypes.c_int(), []
        self._call("cuDeviceGetCount", ctypes.byref(count))
        for i in range(count.value):
            device, memory = ctypes.c_int(), ctypes.c_size_t()
            self._call("cuDeviceGet", ctypes.byref(device), ctypes.c_int(i))
            self._call("cuDeviceTotalMem_v2", ctypes.byref(memory), device)
            capability = f"{self._attribute(_MAJOR, device)}.{self._attribute(_MINOR, device)}"
            out.append({"name": self._name(device), "compute_capability": capability, "memory": memory.value})
        return out

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
        stream = getattr(self._thread, "captures", None)
        self._call("cuLaunchKernel", function, *grid, none, stream, arguments, None)

    def captured(self, launches: Callable[[], None]) -> Graph | None:
        """Return what `launches` would start, to be started at once; None if the driver is too old for it."""
        if not hasattr(self._library, "cuGraphInstantiateWithFlags"):  # of CUDA 11.4
            return None
        stream, graph, ready = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_void_p()
        self._call("cuStreamCreate", ctypes.byref(stream), ctypes.c_uint(0))
        try:
            self._call("cuStreamBeginCapture_v2", stream, ctypes.c_int(_RELAXED))
            self._thread.captures = stream  # of this thread of the host only
            try:
                launches()
            finally:
                self._thread.captures = None
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
def driver() -> Driver:
    """Return the GPU of this process. Errors: NoDevice."""
    return Driver()
