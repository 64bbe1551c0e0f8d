"""Random rigid bodies as system files: six point masses each, so that every inertia is that of a body."""
import random

TORQUE = "so3, torque"


def matrix(rows):
    return "[" + ", ".join("[" + ", ".join(str(x) for x in row) + "]" for row in rows) + "]"


def system_file(system, seed, index):
    """The system file of a body; the numbers are exact decimals."""
    draw = random.Random(f"{system} {seed} {index}")

    def numbers(count, largest=100):
        return [draw.randint(-largest, largest) for _ in range(count)]  # in hundredths

    points = [numbers(3) for _ in range(6)]
    mass = [draw.randint(1, 4) for _ in points]  # in tenths, so the rest is in units of 1e-3 and 1e-5
    unit, n = [[int(r == c) for c in range(3)] for r in range(3)], 3 if system != "se3" else 6
    J = [[sum(m * (sum(y * y for y in x) * unit[r][c] - x[r] * x[c]) for m, x in zip(mass, points)) for c in range(3)]
         for r in range(3)]
    total, first = sum(mass), [sum(m * x[k] for m, x in zip(mass, points)) for k in range(3)]
    hat = [[0, -first[2], first[1]], [first[2], 0, -first[0]], [-first[1], first[0], 0]]
    decimal = [[f'"{J[r][c]}/100000"' for c in range(3)] for r in range(3)]
    if n == 6:
        decimal = [decimal[r] + [f'"{hat[r][c]}/1000"' for c in range(3)] for r in range(3)] + [
            [f'"{-hat[r][c]}/1000"' for c in range(3)] + [f'"{total * unit[r][c]}/10"' for c in range(3)] for r in range(3)]
    lines = ["format = 1", "[algebra]", f'name = "{system[:3]}"', "[lagrangian]", f"inertia = {matrix(decimal)}"]
    if system == TORQUE:
        lines += ["[[force]]", 'kind = "constant"', f"value = {[x / 100 for x in numbers(3)]}"]
    lines += ["[state]", f"velocity = {[x / 100 for x in numbers(n, 150)]}", f"quaternion = {[x / 100 for x in numbers(4)]}"]
    lines += [f"position = {[x / 100 for x in numbers(3)]}"] if n == 6 else []
    return "\n".join(lines + ["[run]", 'step = "1/2"', "steps = 1", ""])
