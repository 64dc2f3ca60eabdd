// The scene that is shown and touched, and its replacement while the servo is running.
//
//   request ──► SceneLoader, in the background ──► take_loaded ──► now()
//                                                    │ the previous one
//                                                    ▼
//                         release on its own thread ◄── kept until the servo no longer uses it
#pragma once

#include "base/background_release.h"
#include "engine/session/scene_loader.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::session {

/// For use by one thread.
class Scenes {
public:
    /// @param first  not null
    Scenes(const device::Workspace &workspace, std::unique_ptr<LoadedScene> first);

    /// Loads in the background; on failure the current scene stays and `error` holds the reason. Of
    /// several requests while loading, the last one counts.
    void request(const std::filesystem::path &file, const SceneLoader::Finish &finish = {});

    /// Makes a loaded scene the current one, with a new number. Returns the previous scene, which
    /// stays valid until the servo no longer uses it; null if none was loaded.
    [[nodiscard]] const LoadedScene *take_loaded();

    /// Call when the servo uses the scene with this number: earlier ones are released.
    void note_in_use(std::uint32_t id);

    /// Scenes requested from now on are fitted into this workspace.
    void set_workspace(const device::Workspace &workspace) { loader_.set_workspace(workspace); }

    [[nodiscard]] LoadedScene &now() { return *now_; }
    [[nodiscard]] const LoadedScene &now() const { return *now_; }
    /// Number of the current scene: 1 for the first.
    [[nodiscard]] std::uint32_t id() const { return id_; }
    /// Number of previous scenes not yet released, as the servo may still use them.
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
