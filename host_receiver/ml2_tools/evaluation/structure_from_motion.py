"""The reference estimator: COLMAP's structure from motion over all images at once."""

import itertools
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import pycolmap

from ..errors import EvaluationError
from ..geometry.camera import Camera
from ..images.rectification import rectify
from .placement import Map
from .trajectory import Images, Progress, Trajectory, untold

# Every fourth image is a key image. The map is made from the key images; the others are placed in
# it afterwards.
_KEY_INTERVAL = 4
# Each key image is matched with the key images that are this many before it.
_REACHES = (1, 2, 4, 8)
# Every sixth key image is matched with all other sixth ones, for loop closure.
_LOOP_INTERVAL = 6
# The least parallax of the first pair and of every point: COLMAP's defaults, then lower values for
# a camera that hardly moves.
_PARALLAX_DEG = ((16.0, 1.5), (2.0, 0.3))
_LARGEST_SIDE_PX = 640
_FEATURES = 1500


def structure_from_motion(
    images: Images, camera: Camera, seed: int = 1, progress: Progress = untold
) -> Trajectory:
    """Estimates the pose of each image; takes a minute or more.

    The lens is taken as given, not refined. The world and its scale are arbitrary. Images that
    cannot be placed are missing from the trajectory.

    Args:
        seed: the seed of all random choices.
        progress: is told of each step.

    Raises:
        EvaluationError: these images give no trajectory.
    """
    pycolmap.logging.minloglevel = pycolmap.logging.Level.FATAL.value
    pycolmap.set_random_seed(seed)
    with TemporaryDirectory() as name:
        folder = Path(name)
        stamps_ns, pinhole = _write_pinhole_images(folder / "images", images, camera)
        if len(stamps_ns) < 2:
            raise EvaluationError(f"expected 2 or more images, found {len(stamps_ns)}")
        names = [_name(stamp_ns) for stamp_ns in stamps_ns]
        keys = names[::_KEY_INTERVAL]
        progress(f"finding features in {len(keys)} key images", 0, 0)
        _find_features(folder, pinhole, keys)
        pairs = list(_pairs(keys))
        progress(f"matching {len(pairs)} pairs of key images", 0, 0)
        _match(folder, pairs)
        mapped = itertools.count(1)
        model = _model(
            folder, seed, lambda: progress("mapping key images", next(mapped), len(keys))
        )
        map_, placed = Map(model, folder / "images"), []
        for index, (stamp_ns, image) in enumerate(zip(stamps_ns, names, strict=True)):
            progress("placing images in the map", index, len(names))
            around = (index - 1) // _KEY_INTERVAL, index // _KEY_INTERVAL + 1
            pose = map_.pose(image, [keys[it] for it in around if 0 <= it < len(keys)])
            placed += [(stamp_ns, pose)] if pose is not None else []
        return placed


def _name(stamp_ns: int) -> str:
    return f"{stamp_ns:020d}.png"


def _write_pinhole_images(
    folder: Path, images: Images, camera: Camera
) -> tuple[list[int], pycolmap.Camera]:
    """Writes the images without distortion; returns their stamps and their pinhole camera."""
    folder.mkdir()
    width, height = camera.lens.width, camera.lens.height
    scale = min(1.0, _LARGEST_SIDE_PX / max(width, height))
    size = round(width * scale), round(height * scale)
    stamps_ns = []
    for stamp_ns, image in images:
        try:
            rectified = rectify(image, camera)
        except ValueError as error:
            raise EvaluationError(str(error)) from error
        small = cv2.resize(rectified, size, interpolation=cv2.INTER_AREA)
        cv2.imwrite(str(folder / _name(stamp_ns)), small, [cv2.IMWRITE_PNG_COMPRESSION, 1])
        stamps_ns.append(stamp_ns)
    fx, _, cx, _, fy, cy, *_ = camera.matrix
    # COLMAP's pixel centres are at halves, ROS's at whole numbers.
    parameters = (fx * scale, fy * scale, (cx + 0.5) * scale, (cy + 0.5) * scale)
    return stamps_ns, pycolmap.Camera(
        model="PINHOLE", width=size[0], height=size[1], params=parameters
    )


def _find_features(folder: Path, pinhole: pycolmap.Camera, keys: Sequence[str]) -> None:
    options = pycolmap.FeatureExtractionOptions()
    options.sift.max_num_features = _FEATURES
    options.sift.first_octave = 0
    reader = pycolmap.ImageReaderOptions()
    reader.camera_model = pinhole.model.name
    reader.camera_params = pinhole.params_to_string()
    pycolmap.extract_features(
        folder / "database",
        folder / "images",
        image_names=keys,
        camera_mode=pycolmap.CameraMode.SINGLE,
        reader_options=reader,
        extraction_options=options,
    )


def _pairs(keys: Sequence[str]) -> Iterator[tuple[str, str]]:
    for reach in _REACHES:
        yield from zip(keys, keys[reach:], strict=False)
    yield from itertools.combinations(keys[::_LOOP_INTERVAL], 2)


def _match(folder: Path, pairs: Sequence[tuple[str, str]]) -> None:
    path = folder / "pairs.txt"
    path.write_text("".join(f"{one} {other}\n" for one, other in dict.fromkeys(pairs)))
    pairing = pycolmap.ImportedPairingOptions()
    pairing.match_list_path = path
    pycolmap.match_image_pairs(folder / "database", pairing_options=pairing)


def _model(folder: Path, seed: int, on_image: Callable[[], None]) -> pycolmap.Reconstruction:
    """Returns the largest reconstruction of the key images; `on_image` hears of each.

    Raises:
        EvaluationError: the images show no parallax.
    """
    options = pycolmap.IncrementalPipelineOptions()
    options.random_seed = seed
    options.extract_colors = False
    options.ba_refine_focal_length = options.ba_refine_extra_params = False
    options.mapper.abs_pose_refine_focal_length = False
    options.mapper.abs_pose_refine_extra_params = False
    for first_deg, least_deg in _PARALLAX_DEG:
        options.mapper.init_min_tri_angle = first_deg
        options.mapper.filter_min_tri_angle = options.triangulation.min_angle = least_deg
        paths = folder / "database", folder / "images", folder
        models = pycolmap.incremental_mapping(*paths, options, next_image_callback=on_image)
        if models:
            return max(models.values(), key=lambda model: model.num_reg_images())
    raise EvaluationError("structure from motion finds no parallax: did the camera move sideways?")
