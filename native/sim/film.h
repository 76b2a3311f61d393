// Pictures drawn once and shown again and again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace ml2sim {

/** What decides the pixels of a film; equal descriptions have equal pixels. */
struct FilmPlan {
    std::string name;   ///< For people, such as world_left.
    std::string inputs; ///< Everything that draw depends on.
    size_t frame_bytes;
    size_t count;
    /** Draws one frame. Runs in several threads at once. */
    std::function<void(size_t index, uint8_t *frame)> draw;
};

/**
 * Frames in shared memory. With a real clock the whole film is drawn by two threads before it is shown, which takes
 * seconds, or comes from the cache folder at once; with a manual clock, where drawing costs no time, each frame is
 * drawn when it is first asked for.
 */
class Film {
  public:
    /** The film of a plan, drawn if there is none yet. Any thread; who wants the same one waits. */
    static std::shared_ptr<Film> of(const FilmPlan &plan);

    /** Whether anybody waits for a film. Any thread. */
    static bool isDrawing();

    Film(const FilmPlan &plan, bool drawsAhead);
    ~Film();
    Film(const Film &) = delete;
    Film &operator=(const Film &) = delete;

    /** Read only, valid as long as the film. Any thread. */
    const uint8_t *frame(size_t index);
    size_t count() const { return plan_.count; }

  private:
    void map(int file);
    bool load(const std::string &path);
    void drawAll();

    struct Drawn;
    FilmPlan plan_;
    size_t stride_;
    uint8_t *frames_ = nullptr;
    std::unique_ptr<Drawn> drawn_; ///< Null when all are.
};

} // namespace ml2sim
