// A stepper in C++17 to start from: one file, no library. Replace `step` by your method.
//
//     g++ -O2 -std=c++17 properties/steppers/template.cpp -o stepper
//     euler-poincare probe --order 4 -- ./stepper
//
// As it is, it takes a step of the classical Runge-Kutta method on (mu, g), for free motion on any Lie algebra:
//     d/dt mu_a = C^d_ba eta^b mu_d,   dg/dt = g eta^a E_a,   mu = I eta.
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

using Numbers = std::vector<double>;

/// Thrown where the method does not apply. Keep numbers out of the reason: reasons are counted.
struct Unsupported : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The keys of a request. Each value is a number or a flat list of numbers, but for `force`: a list of objects, kept as text.
struct Request {
    std::map<std::string, Numbers> numbers;
    std::string force;

    explicit Request(const std::string &line) {
        for (size_t i = line.find('"'); i != std::string::npos; i = line.find('"', i)) {
            const size_t end = line.find('"', i + 1), from = line.find(':', end) + 1;
            const std::string key = line.substr(i + 1, end - i - 1);
            size_t depth = 0, to = from;  // the value ends where its brackets are closed
            while (depth > 0 || (line[to] != ',' && line[to] != '}')) {
                depth += line[to] == '[' || line[to] == '{';
                depth -= line[to] == ']' || line[to] == '}';
                if (++to >= line.size()) throw std::runtime_error("not a request");
            }
            const std::string value = line.substr(from, to - from);
            if (key == "force") force = value;
            else for (const char *p = value.c_str(); *p;) {
                char *after;
                const double x = std::strtod(p, &after);
                if (after == p) ++p;
                else numbers[key].push_back(x), p = after;
            }
            i = to;
        }
    }

    Numbers operator[](const std::string &key) const {
        const auto found = numbers.find(key);
        return found == numbers.end() ? Numbers{} : found->second;
    }

    bool has_force() const { return force.find('{') != std::string::npos; }
};

/// The solution of A x = b, A symmetric and positive definite, by rows.
Numbers solve(Numbers A, Numbers b) {
    const size_t n = b.size();
    for (size_t k = 0; k < n; ++k)
        for (size_t r = k + 1; r < n; ++r) {
            const double factor = A[r * n + k] / A[k * n + k];
            for (size_t c = k; c < n; ++c) A[r * n + c] -= factor * A[k * n + c];
            b[r] -= factor * b[k];
        }
    for (size_t k = n; k-- > 0;) {
        for (size_t c = k + 1; c < n; ++c) b[k] -= A[k * n + c] * b[c];
        b[k] /= A[k * n + k];
    }
    return b;
}

/// A state: mu, then g by rows.
Numbers rate(const Request &q, const Numbers &y) {
    const Numbers C = q["constants"], E = q["basis"];
    const size_t n = size_t(q["dimension"][0]), m = size_t(q["size"][0]);
    const Numbers eta = solve(q["inertia"], Numbers(y.begin(), y.begin() + n));
    Numbers d(y.size(), 0.0);
    for (size_t b = 0; b < n; ++b)
        for (size_t a = 0; a < n; ++a) {
            for (size_t c = 0; c < n; ++c) d[a] += C[(b * n + a) * n + c] * eta[b] * y[c];
        }
    for (size_t a = 0; a < n; ++a)
        for (size_t r = 0; r < m; ++r)
            for (size_t j = 0; j < m; ++j)
                for (size_t c = 0; c < m; ++c) d[n + r * m + c] += y[n + r * m + j] * eta[a] * E[(a * m + j) * m + c];
    return d;
}

Numbers plus(Numbers y, double h, const Numbers &k) {
    for (size_t i = 0; i < y.size(); ++i) y[i] += h * k[i];
    return y;
}

Numbers step(const Request &q, const Numbers &y) {
    if (q["version"] != Numbers{1} || q.has_force() || !q["quartic"].empty()) throw Unsupported("only free motion");
    const double h = q["step"][0];
    const Numbers k1 = rate(q, y), k2 = rate(q, plus(y, h / 2, k1)), k3 = rate(q, plus(y, h / 2, k2)), k4 = rate(q, plus(y, h, k3));
    return plus(plus(plus(plus(y, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
}

void print(const Numbers &list, size_t from, size_t to) {
    for (size_t i = from; i < to; ++i) std::printf("%s%.17g", i > from ? ", " : "", list[i]);
}

/// What the method supports, the first answer: random systems are drawn of these. The first request may be of any system, and is not looked at.
const char *const SUPPORTS = R"({"supports": {"algebras": ["so3", "se3"], "quartic": false, "forces": []}})";

int main() {
    bool told = false;
    for (std::string line; std::getline(std::cin, line); std::fflush(stdout)) {  // a line that stays in a buffer looks like a program that hangs
        if (!told) {
            told = true;
            std::puts(SUPPORTS);
            continue;
        }
        const Request q(line);
        Numbers y = q["mu"];
        const Numbers g = q["g"];
        const size_t n = y.size();
        y.insert(y.end(), g.begin(), g.end());
        try {
            y = step(q, y);
            std::printf("{\"mu\": [");
            print(y, 0, n);
            std::printf("], \"g\": [");
            print(y, n, y.size());
            std::printf("]}\n");
        } catch (const Unsupported &reason) {
            std::printf("{\"unsupported\": \"%s\"}\n", reason.what());
        }
    }
}
