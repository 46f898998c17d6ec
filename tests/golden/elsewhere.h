// SPDX-License-Identifier: MIT
// Entries that no test of this program reads yet: counted, named, and not passed over in silence. Whoever writes the GOLDEN test
// of an entry takes its row out; a row with a test fails the run, like an entry with neither.
#pragma once

namespace plumb::golden {

inline constexpr const char* kElsewhere[] = {
    // Part 4, ray tracing: issue 5.
    "s181_ray_counts",
    "s1821_ray_sphere",
    "s1821_case_miss",
    "s1821_case_graze",
    "s1821_case_behind",
    "s1821_case_inside",
    "s1822_ray_plane",
    "s1822_parallel",
    "s1822_behind",
    "s1823_reflect_ray",
    "s1823_reflect_ray_grazing",
    "s1823_reflect_ray_backside",
    "s1824_refract",
    "s1824_refract_unit",
    "s1824_total_internal_reflection",
    "s1824_refract_normal_incidence",
    "s183_checker_275_450",
    "s183_checker_-320_380",
    "s183_checker_boundaries",
    "s1841_corner_sharing",
    "s1841_corner_average",
    "s1842_adaptive_depth",
    "s1843_shadow_attenuation",
    "s185_scene",
    "s185_sample_pixels",
    "s185_hand_checkerboard",
    "s185_hand_sphere1",
    "s185_truncation",
    "s185_frame_statistics",
    "s185_colour_table_dead_code",
};

}  // namespace plumb::golden
