// The scene that is shown and touched, and its exchange for another while the servo goes on.
//
//   request ──► SceneLoader, in the background ──► take_loaded ──► now()
//                                                    │ the one before
//                                                    ▼
//                   release on a thread of its own ◄── kept until the servo has let go of it
#pragma once

#include "base/background_release.h"
#include "engine/session/scene_loader.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::session {

/// Of one thread.
class Scenes {
public:
    /// @param first  not null
    Scenes(const device::Workspace &workspace, std::unique_ptr<LoadedScene> first);

    /// Loads in the background; on failure the present one stays and `error` tells why. Of several
    /// asked for meanwhile the last wins.
    void request(const std::filesystem::path &file, const SceneLoader::Finish &finish = {});

    /// Makes what has been loaded the present one, under a new number. Nothing where none has.
    /// Returns the one before: it stays as it is until the servo has let go of it.
    [[nodiscard]] const LoadedScene *take_loaded();

    /// The servo works on the scene of that number, so it has let go of all before.
    void note_in_use(std::uint32_t id);

    /// That scenes requested from now on are fitted into.
    void set_workspace(const device::Workspace &workspace) { loader_.set_workspace(workspace); }

    [[nodiscard]] LoadedScene &now() { return *now_; }
    [[nodiscard]] const LoadedScene &now() const { return *now_; }
    /// 1 for the first.
    [[nodiscard]] std::uint32_t id() const { return id_; }
    /// That are not released yet, since the servo may still be touching them.
    [[nodiscard]] std::size_t retired() const { return retired_.size(); }

    [[nodiscard]] bool is_loading() const { return loader_.is_loading(); }
    [[nodiscard]] std::string progress() const { return loader_.progress(); }
    [[nodiscard]] const std::string &error() const { return loader_.error(); }

private:
    BackgroundRelease<LoadedScene> release_;
    std::unique_ptr<LoadedScene> now_;
    std::uint32_t id_ = 1;
    std::vector<std::unique_ptr<LoadedScene>> retired_;
    SceneLoader loader_;
};

} // namespace springdrive::session
