#!/usr/bin/python3
"""sandbox.py UNIT WRITABLE... -- COMMAND... - runs a command under what a unit file asks systemd for,
as far as one process can do it to itself: a system that is read-only but for the folders named, no
capability, no new privileges, the unit's system call filter with its error number, no memory that is
written and executed, its address families, no namespaces.

Exits 77 where the machine does not let it. Not done: users, devices, networks and the folders that
systemd hides.
"""
import configparser
import ctypes
import ctypes.util
import errno
import os
import subprocess
import sys

libc = ctypes.CDLL(None, use_errno=True)

CLONE_NEWNS, MS_BIND, MS_REC, MS_PRIVATE = 0x20000, 0x1000, 0x4000, 0x40000
SYS_CAPSET, SYS_MOUNT_SETATTR, AT_FDCWD, AT_RECURSIVE, MOUNT_ATTR_RDONLY = 126, 442, -100, 0x8000, 1
PR_CAPBSET_DROP, PR_SET_NO_NEW_PRIVS, LAST_CAPABILITY = 24, 38, 40
PROT_WRITE, PROT_EXEC, SHM_EXEC = 2, 4, 0o100000
ALLOW, ERRNO = 0x7fff0000, 0x00050000
EQ, GT, MASKED_EQ = 4, 6, 7
NAMESPACES = 0x7e020080  # the CLONE_NEW* flags
FAMILIES = {"AF_UNIX": 1, "AF_INET": 2, "AF_INET6": 10, "AF_NETLINK": 16}


def cannot(what):
    print(f"sandbox: {what}", file=sys.stderr)
    sys.exit(77)


def check(result, what):
    if result < 0:
        cannot(f"{what}: {os.strerror(ctypes.get_errno())}")


class Unit(dict):
    """The settings of [Service]; a list of values for each."""

    def __init__(self, path):
        class Every(dict):
            def __setitem__(self, key, value):
                if isinstance(value, list) and key in self:
                    self[key].extend(value)
                else:
                    super().__setitem__(key, value)
        parser = configparser.RawConfigParser(strict=False, dict_type=Every, delimiters="=")
        parser.optionxform = str
        parser.read(path)
        for key, text in parser.items("Service"):
            self[key] = text.split("\n")

    def on(self, key):
        return self.get(key, ["no"])[-1] == "yes"


class MountAttributes(ctypes.Structure):
    _fields_ = [(name, ctypes.c_uint64) for name in ("set", "clear", "propagation", "user")]


def set_mount(path, flags, attributes):
    check(libc.syscall(SYS_MOUNT_SETATTR, AT_FDCWD, os.fsencode(path), flags,
                       ctypes.byref(attributes), ctypes.sizeof(attributes)), f"mount {path}")


def mount_read_only(writable):
    check(libc.unshare(CLONE_NEWNS), "mount namespace")
    check(libc.mount(b"none", b"/", None, MS_REC | MS_PRIVATE, None), "private mounts")
    for path in writable:
        check(libc.mount(os.fsencode(path), os.fsencode(path), None, MS_BIND, None), path)
    set_mount("/", AT_RECURSIVE, MountAttributes(set=MOUNT_ATTR_RDONLY))
    for path in writable:
        set_mount(path, 0, MountAttributes(clear=MOUNT_ATTR_RDONLY))


def drop_capabilities():
    for capability in range(LAST_CAPABILITY + 1):
        libc.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)
    header = (ctypes.c_uint32 * 2)(0x20080522, 0)
    check(libc.syscall(SYS_CAPSET, header, (ctypes.c_uint32 * 6)()), "capabilities")


class Comparison(ctypes.Structure):
    _fields_ = [("argument", ctypes.c_uint), ("operator", ctypes.c_int), ("a", ctypes.c_uint64),
                ("b", ctypes.c_uint64)]


class Filter:
    def __init__(self, default):
        name = ctypes.util.find_library("seccomp")
        if not name:
            cannot("no libseccomp")
        self.library = ctypes.CDLL(name)
        self.library.seccomp_init.restype = ctypes.c_void_p
        self.context = ctypes.c_void_p(self.library.seccomp_init(default))

    def rule(self, action, name, *comparisons):
        number = self.library.seccomp_syscall_resolve_name(name.encode())
        if number < 0:  # another architecture's
            return
        rules = (Comparison * len(comparisons))(*comparisons)
        self.library.seccomp_rule_add_array(self.context, ctypes.c_uint32(action), number,
                                            len(comparisons), rules)

    def load(self):
        if self.library.seccomp_load(self.context):
            cannot("no system call filter")


def members(name):
    """System calls of a set of systemd's, with those of the sets in it."""
    if not name.startswith("@"):
        return {name}
    listed = subprocess.run(["systemd-analyze", "--no-pager", "syscall-filter", name], check=True,
                            capture_output=True, text=True).stdout.splitlines()
    words = [line.strip() for line in listed[1:] if line.startswith(" ")]
    return set().union(*(members(word) for word in words if not word.startswith("#")))


def filter_calls(unit):
    calls = set()
    for line in unit["SystemCallFilter"]:
        names = set().union(*(members(word) for word in line.removeprefix("~").split()))
        calls = calls - names if line.startswith("~") else calls | names
    number = getattr(errno, unit["SystemCallErrorNumber"][-1])
    rules = Filter(ERRNO | number)
    for name in sorted(calls | members("@default")):
        rules.rule(ALLOW, name)
    rules.load()


def filter_arguments(unit):
    rules = Filter(ALLOW)
    deny = ERRNO | errno.EPERM
    if unit.on("MemoryDenyWriteExecute"):
        both = PROT_WRITE | PROT_EXEC
        rules.rule(deny, "mmap", Comparison(2, MASKED_EQ, both, both))
        rules.rule(deny, "mprotect", Comparison(2, MASKED_EQ, PROT_EXEC, PROT_EXEC))
        rules.rule(deny, "pkey_mprotect", Comparison(2, MASKED_EQ, PROT_EXEC, PROT_EXEC))
        rules.rule(deny, "shmat", Comparison(2, MASKED_EQ, SHM_EXEC, SHM_EXEC))
    known = {FAMILIES[word] for word in unit["RestrictAddressFamilies"][-1].split()}
    for family in set(range(max(known) + 1)) - known:
        rules.rule(ERRNO | errno.EAFNOSUPPORT, "socket", Comparison(0, EQ, family))
    rules.rule(ERRNO | errno.EAFNOSUPPORT, "socket", Comparison(0, GT, max(known)))
    if unit.on("RestrictNamespaces"):
        rules.rule(ERRNO | errno.ENOSYS, "clone3")
        rules.rule(deny, "unshare")
        rules.rule(deny, "setns")
        for bit in range(32):
            if NAMESPACES >> bit & 1:
                rules.rule(deny, "clone", Comparison(0, MASKED_EQ, 1 << bit, 1 << bit))
    rules.load()


def main():
    unit = Unit(sys.argv[1])
    split = sys.argv.index("--")
    mount_read_only(sys.argv[2:split])
    drop_capabilities()
    libc.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)
    os.umask(int(unit["UMask"][-1], 8))
    filter_arguments(unit)
    filter_calls(unit)
    os.execv(sys.argv[split + 1], sys.argv[split + 1:])


if __name__ == "__main__":
    main()
