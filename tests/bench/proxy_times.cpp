#include "tests/bench/proxy_times.h"

#include "engine/contact/proxy/proxy.h"
#include "tests/bench/stopwatch.h"

#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>

namespace springdrive::bench {

namespace {

constexpr std::size_t kSweptBytes = 96'000'000;
constexpr std::size_t kCacheLineBytes = 64;

/// A proxy that has moved to the first tip from outside.
contact::Proxy proxy_at(const contact::HapticSurface &surface, const Vector3 &tip_m) {
    contact::Proxy proxy;
    proxy.reset(1.5 * tip_m);
    benchmark::DoNotOptimize(proxy.update(surface, tip_m));
    return proxy;
}

/// Evicts everything else from the caches.
class Sweep {
public:
    void operator()() {
        for (std::size_t i = 0; i < swept_.size(); i += kCacheLineBytes) {
            ++swept_[i];
        }
        benchmark::ClobberMemory();
    }

private:
    std::vector<std::uint8_t> swept_ = std::vector<std::uint8_t>(kSweptBytes);
};

} // namespace

ProxyTimes time_proxy(const contact::HapticSurface &surface, const std::vector<Vector3> &tips_m) {
    ProxyTimes times;
    times.raw_ns.reserve(kRepeats * tips_m.size());
    std::size_t touching = 0;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
        contact::Proxy proxy = proxy_at(surface, tips_m.front());
        for (const Vector3 &tip_m : tips_m) {
            contact::Contact contact;
            times.raw_ns.push_back(time_ns([&] {
                contact = proxy.update(surface, tip_m);
                benchmark::DoNotOptimize(contact);
            }));
            touching += contact.touching ? 1 : 0;
        }
    }
    times.touching = static_cast<double>(touching) / static_cast<double>(times.raw_ns.size());
    times.floor_ns = min_of_repeats(times.raw_ns);
    return times;
}

std::vector<double> time_proxy_cold(const contact::HapticSurface &surface,
                                    const std::vector<Vector3> &tips_m) {
    Sweep sweep;
    contact::Proxy proxy = proxy_at(surface, tips_m.front());
    std::vector<double> times_ns;
    times_ns.reserve(tips_m.size());
    for (const Vector3 &tip_m : tips_m) {
        sweep();
        times_ns.push_back(
            time_ns([&] { benchmark::DoNotOptimize(proxy.update(surface, tip_m)); }));
    }
    return times_ns;
}

} // namespace springdrive::bench
