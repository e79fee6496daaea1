"""What the bits of products depend on besides the program: for which instruction set PoCL compiles the kernels, and the
versions of PoCL, LLVM and the C library.

Debian's PoCL brings its library of kernels in several forms, one for each instruction set, takes the best that the
processor has, and compiles for one processor that stands for the set: all processors of a set, of any maker, get the
same kernels. POCL_KERNELLIB_NAME names a lesser form than the best; PoCL itself keeps to the best where the processor
has not what is named. A PoCL that was built for one machine compiles for the processor at hand; POCL_LLVM_CPU_NAME
(PoCL 5 and later) names another.
"""

import ctypes
import json
import os
import pathlib
import platform
import re
import subprocess

#: The processor that PoCL compiles for -> the form of its library, which is what an instruction set is called here. In
#: order: each has what those before it have (avx_fma4 apart, which AMD alone made).
SETS = {
    "athlon64": "sse2",
    "x86-64": "sse2",
    "core2": "ssse3",
    "penryn": "sse41",
    "sandybridge": "avx",
    "ivybridge": "avx_f16c",
    "bdver1": "avx_fma4",
    "haswell": "avx2",
    "skylake-avx512": "avx512",
}
PROCESSORS = {name: processor for processor, name in SETS.items()}
#: Flags of /proc/cpuinfo by which a processor that is not in SETS is counted among a set, the best first.
FLAGS = {"avx512": {"avx512f", "avx512bw", "avx512dq", "avx512vl", "fma"}, "avx2": {"avx2", "fma", "bmi1", "bmi2"}}


def asking_for(instruction_set):
    """Environment in which PoCL compiles for that set, where the processor has it."""
    return {"POCL_KERNELLIB_NAME": instruction_set, "POCL_LLVM_CPU_NAME": PROCESSORS[instruction_set]}


def processor_flags():
    """Of /proc/cpuinfo; none where there is no such file."""
    path = pathlib.Path("/proc/cpuinfo")
    found = re.search(r"^flags\s*:(.*)$", path.read_text(), re.M) if path.exists() else None
    return set(found[1].split()) if found else set()


class Device:
    """The first device of PoCL, else the first of all, as the program lists it in an environment."""

    def __init__(self, raycube, env=None):
        env = {**os.environ, **(env or {})}
        done = subprocess.run([raycube, "devices", "--json"], check=True, capture_output=True, text=True, env=env)
        devices = json.loads(done.stdout)["devices"]
        one = next((each for each in devices if each["platform"] == "Portable Computing Language"), devices[0])
        self.number, self.name, self.driver, self.is_cpu = one["number"], one["name"], one["driver"], one["cpu"]
        # PoCL's version of a device ends in "HSTR: pthread-x86_64-pc-linux-gnu-haswell".
        found = re.search(r"HSTR: .*x86_64-pc-linux-gnu-(\S+)", one["version"])
        self.processor = found[1] if found else None

    def instruction_set(self):
        """What its kernels are compiled for, as in SETS; None where that is no processor of x86-64."""
        if self.processor is None:
            return None
        flags = processor_flags()
        by_flags = next((name for name, needed in FLAGS.items() if needed <= flags), "sse2")
        return SETS.get(self.processor, by_flags)


def llvm_version():
    """Of PoCL's compiler, as its platform states it: "OpenCL 3.0 PoCL 3.1+debian  Linux, ..., LLVM 15.0.6, ..."."""
    try:
        library = ctypes.CDLL("libOpenCL.so.1")
    except OSError:
        return "unknown"
    platforms, count = (ctypes.c_void_p * 16)(), ctypes.c_uint()
    if library.clGetPlatformIDs(16, platforms, ctypes.byref(count)) != 0:
        return "unknown"
    CL_PLATFORM_VERSION = 0x0901
    for one in platforms[: min(count.value, 16)]:
        text = ctypes.create_string_buffer(1024)
        library.clGetPlatformInfo(ctypes.c_void_p(one), CL_PLATFORM_VERSION, ctypes.c_size_t(1024), text, None)
        found = re.search(rb"PoCL .*LLVM ([0-9.]+)", text.value, re.I)
        if found:
            return found[1].decode()
    return "unknown"


def versions(device, compiler):
    """What else bits may depend on, as the record's second line states it."""
    return f"PoCL {device.driver}, LLVM {llvm_version()}, glibc {platform.libc_ver()[1]}, compiler {compiler}"
