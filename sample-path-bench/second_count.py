"""Counts the sample path's instructions a second time: QEMU runs the same ELF, and every instruction is a step.

    python3 sample-path-bench/second_count.py ELF path_16 sums_16 path_with_jacks_16

Needs qemu-system-arm (Debian's package). The machine is QEMU's Netduino Plus 2, a Cortex-M4 with flash and RAM at the
addresses of the board's; the program needs nothing else. The debugger's protocol is spoken here, so no debugger is
needed.
"""

import socket
import subprocess
import sys
import time

CALLS = 4
SP, LR, PC = 13, 14, 15


class Debugger:
    def __init__(self, port):
        for _ in range(100):
            try:
                self.link = socket.create_connection(("127.0.0.1", port))
                break
            except ConnectionRefusedError:
                time.sleep(0.1)
        self.link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.input = self.link.makefile("rb")

    def ask(self, text):
        self.link.sendall(b"$%s#%02x" % (text.encode(), sum(text.encode()) & 0xFF))
        while self.input.read(1) != b"$":
            pass
        answer = b""
        while not answer.endswith(b"#"):
            answer += self.input.read(1)
        self.input.read(2)
        self.link.sendall(b"+")
        return answer[:-1].decode()

    def registers(self):
        answer = bytes.fromhex(self.ask("g")[:128])
        return [int.from_bytes(answer[at : at + 4], "little") for at in range(0, 64, 4)]

    def count_call(self, address):
        self.ask("Z0,%x,2" % address)
        self.ask("c")
        self.ask("z0,%x,2" % address)
        before, steps = self.registers(), 0
        back, stack = before[LR] & ~1, before[SP]
        while True:
            self.ask("s")
            steps += 1
            now = self.registers()
            if (now[PC], now[SP]) == (back, stack):
                return steps


def symbols(elf):
    """Function symbols of a 32-bit little-endian ELF: name to address."""
    data = open(elf, "rb").read()
    word = lambda at, size=4: int.from_bytes(data[at : at + size], "little")
    table, entry, number = word(32), word(46, 2), word(48, 2)
    sections = [table + entry * index for index in range(number)]
    found = {}
    for section in sections:
        if word(section + 4) != 2:
            continue
        names = word(sections[word(section + 24)] + 16)
        start, size = word(section + 16), word(section + 20)
        for at in range(start, start + size, 16):
            name = names + word(at)
            found[data[name : data.index(0, name)].decode()] = word(at + 4) & ~1
    return found


def main():
    elf, names = sys.argv[1], sys.argv[2:]
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    qemu = ["qemu-system-arm", "-M", "netduinoplus2", "-display", "none", "-serial", "none", "-monitor", "none"]
    machine = subprocess.Popen(qemu + ["-kernel", elf, "-S", "-gdb", f"tcp:127.0.0.1:{port}"])
    try:
        board, addresses = Debugger(port), symbols(elf)
        for name in names:
            print(name, *(board.count_call(addresses[name]) for _ in range(CALLS)))
    finally:
        machine.kill()


if __name__ == "__main__":
    main()
