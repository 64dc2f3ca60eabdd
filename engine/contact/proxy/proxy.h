// The proxy (god-object): where the tip would be if it could not penetrate the surface.
//
// Each tick it descends towards the tip, in free space and along the surface, to the nearest point
// that it can reach. Every motion is swept against the surface, so whatever the tip does, the
// proxy's path never crosses the surface. Ridges, steps and pits too small to feel do not hold it.
// Where the material has friction it lags behind, as far as Coulomb's law allows.
//
// God-object: C. Zilles and K. Salisbury, "A constraint-based god-object method for haptic
// display", 1995. Proxy: D. Ruspini, K. Kolarov and O. Khatib, "The haptic display of complex
// graphical environments", 1997. What differs here:
//
//   - a point moves rather than a sphere, unless it is given a radius; both keep a clearance
//   - the descent continues within a tick until no nearer point can be reached, within a budget, so
//     that the contact of a tick does not depend on how the previous tick ended
//   - force shading does not rotate the force: the surface itself is curved, see
//     engine/scene/curved_patches.h, so that no closed path gives or takes energy
//   - friction is applied along the path that the proxy would take without it
#pragma once

#include "base/vector.h"
#include "engine/contact/contact.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/contact/proxy/contact_planes.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/contact/proxy/proxy_solver.h"

#include <cmath>
#include <cstdint>
#include <optional>

namespace springdrive::contact {

class Proxy {
public:
    /// @param radius_m  the distance it keeps from every surface; at least kClearance_m
    explicit Proxy(double radius_m = 0.0);

    /// Starts free at the tip, whichever side of the surface it is on. A tip that is not finite is
    /// ignored.
    void reset(const Vector3 &tip_m) noexcept;

    /// Moves the proxy to the point nearest to the tip that it can reach without crossing the
    /// surface. RT-safe: bounded effort, no allocation, lock, I/O or throw.
    ///
    /// A tip that is not finite, or a kilometre away, leaves the proxy where it is and gives a free
    /// contact; stopping the device is up to the safety monitor.
    Contact update(const HapticSurface &surface, const Vector3 &tip_m) noexcept;

    /// The path of the last update.
    [[nodiscard]] const ProxyPath &path() const noexcept { return path_; }

private:
    void update_neighbourhood(const HapticSurface &surface, const Vector3 &tip_m,
                              SolverBudget &budget) noexcept;
    void search_neighbourhood(const HapticSurface &surface, const Vector3 &centre_m,
                              SolverBudget &budget) noexcept;
    [[nodiscard]] bool moves_freely(const HapticSurface &surface, const Vector3 &tip_m,
                                    SolverBudget &budget) const noexcept;
    [[nodiscard]] std::optional<ShapeSlide> free_slide(const HapticSurface &surface,
                                                       const Vector3 &tip_m) const noexcept;
    void follow(const ShapeSlide &slide) noexcept;
    [[nodiscard]] bool move_to_rest(const ProxySolver &solver, const HapticSurface &surface,
                                    const Vector3 &tip_m, SolverBudget &budget) noexcept;
    [[nodiscard]] bool jump_to_nearer_rest(const ProxySolver &solver, const HapticSurface &surface,
                                           const Vector3 &tip_m) noexcept;
    [[nodiscard]] bool leave_vertex(const ProxySolver &solver, const HapticSurface &surface,
                                    const Vector3 &tip_m, SolverBudget &budget) noexcept;
    [[nodiscard]] bool leave_along(const Vector3 &motion_m, const Vector3 &above_m,
                                   const ProxySolver &solver, const Vector3 &tip_m) noexcept;
    void apply_friction(const ProxySolver &solver, const Rest &before,
                        const SurfaceMaterial &material, const Vector3 &tip_m) noexcept;

    double reach_m_;
    std::uint64_t surface_serial_ = 0; ///< of the surface in the last update
    Rest rest_;
    bool sticks_ = false; ///< friction holds it
    bool slides_ = false; ///< against dynamic friction
    Vector3 last_tip_m_{Vector3::Zero()};
    Vector3 pit_m_{Vector3::Constant(NAN)};     ///< where a search for all ways out found none
    Vector3 pit_tip_m_{Vector3::Constant(NAN)}; ///< the tip then
    Neighbourhood near_;
    double search_radius_m_;             ///< radius of the next neighbourhood
    int effort_ = SolverBudget::kEffort; ///< of the next update; see SearchBudget
    ProxyPath path_;
};

} // namespace springdrive::contact
