# A stepper in Julia to start from: one file, Base alone. Replace `take_step` by your method.
#
#     euler-poincare probe --order 4 -- julia properties/steppers/template.jl
#
# As it is, it takes a step of the classical Runge-Kutta method on (mu, g), for free motion on any Lie algebra:
#     d/dt mu_a = C^d_ba eta^b mu_d,   dg/dt = g eta^a E_a,   mu = I eta.

"The keys of a request. Each value is a list of numbers, but for `force`: true where there is one."
function parse_request(line)
    q = Dict{String,Any}()
    # A key, then a number or a flat list of numbers.
    for found in eachmatch(r"\"(\w+)\" *: *(\[[-+.\deE, ]*\]|[-+.\deE]+)", line)
        numbers = [parse(Float64, number.match) for number in eachmatch(r"[-+.\deE]+", found[2])]
        get!(q, String(found[1]), numbers) # the first: terms of the force have keys of their own
    end
    q["force"] = occursin("\"kind\"", line)
    return q
end

"An array of the request: indices run from 1 here, and the first runs fastest, so they are in reverse."
table(q, key, sizes...) = reshape(q[key], sizes...)

"dmu/dt and dg/dt; g is stored transposed, as it comes."
function rate(q, mu, g)
    n, m = Int(q["dimension"][1]), Int(q["size"][1])
    C = table(q, "constants", n, n, n) # C^c_ab is C[c, b, a]
    eta = table(q, "inertia", n, n) \ mu
    dmu = [sum(C[d, a, b] * eta[b] * mu[d] for b in 1:n, d in 1:n) for a in 1:n]
    if m == 0
        return dmu, g
    end
    E = table(q, "basis", m, m, n)
    hat = sum(eta[a] * E[:, :, a] for a in 1:n) # transposed, too
    return dmu, hat * g
end

"The state after the step, or the reason why there is none. Keep numbers out of it: reasons are counted."
function take_step(q)
    if q["version"] != [1.0] || q["force"] || haskey(q, "quartic")
        return "only free motion"
    end
    m, h, mu = Int(q["size"][1]), q["step"][1], q["mu"]
    g = m == 0 ? zeros(0, 0) : table(q, "g", m, m)
    k1 = rate(q, mu, g)
    k2 = rate(q, mu + h / 2 * k1[1], g + h / 2 * k1[2])
    k3 = rate(q, mu + h / 2 * k2[1], g + h / 2 * k2[2])
    k4 = rate(q, mu + h * k3[1], g + h * k3[2])
    after(y, k) = y + h / 6 * (k1[k] + 2 * k2[k] + 2 * k3[k] + k4[k])
    return after(mu, 1), after(g, 2)
end

# What the method supports, the first answer: random systems are drawn of these. The first request may be of any system, and is not
# looked at.
const SUPPORTS = "{\"supports\": {\"algebras\": [\"so3\", \"se3\"], \"quartic\": false, \"forces\": []}}"

function answer(q)
    after = take_step(q)
    if after isa String
        return "{\"unsupported\": \"$after\"}"
    end
    return "{\"mu\": [" * join(after[1], ", ") * "], \"g\": [" * join(after[2], ", ") * "]}"
end

function main()
    for (number, line) in enumerate(eachline(stdin))
        println(number == 1 ? SUPPORTS : answer(parse_request(line)))
        flush(stdout) # a line that stays in a buffer looks like a program that hangs
    end
end

main()
