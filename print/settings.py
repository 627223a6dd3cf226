"""What PrusaSlicer is told: a profile as the text of its configuration file.

Keys and values are legal from PrusaSlicer 2.5 to 2.9. What stands here is written although
it may be the slicer's default, because defaults change from version to version.
"""

from __future__ import annotations

from morph.print.printer import Profile

SLIM = 4.0
"""Things higher than this many times their narrower side get a brim, so that they stand."""
BRIM_MM = 4.0
"""Width of the brim of what is slim."""
SKIRT_MM = 3.0
"""Distance of the skirt, with which the nozzle is primed, from what is printed."""

SUPPORT_SPACING_MM = 2.5
"""Distance between the lines of support."""

# One line around a part is about 0.45 mm wide; the speeds, mm/s, are what a printer without
# input shaping manages: those of a Prusa i3 MK3.
STEADY = {
    "printer_technology": "FFF",
    "gcode_flavor": "marlin2",
    "perimeter_generator": "arachne",
    "ensure_vertical_shell_thickness": "1",
    "extra_perimeters": "0",
    "thick_bridges": "0",
    "infill_every_layers": "1",
    "infill_overlap": "15%",
    "infill_anchor": "2.5",
    "infill_anchor_max": "12",
    "solid_infill_below_area": "0",
    "top_solid_min_thickness": "0",
    "bottom_solid_min_thickness": "0",
    "top_fill_pattern": "monotonic",
    "bottom_fill_pattern": "monotonic",
    "gap_fill_enabled": "1",
    "elefant_foot_compensation": "0",
    "xy_size_compensation": "0",
    "z_offset": "0",
    "spiral_vase": "0",
    "ironing": "0",
    "raft_layers": "0",
    "wipe_tower": "0",
    "seam_position": "aligned",
    "resolution": "0",
    "gcode_resolution": "0.0125",
    "support_material": "1",
    "support_material_auto": "1",
    "support_material_buildplate_only": "0",
    "support_material_style": "snug",
    "support_material_spacing": f"{SUPPORT_SPACING_MM:g}",
    "support_material_with_sheath": "0",
    "support_material_interface_layers": "2",
    "support_material_interface_spacing": "0.2",
    "support_material_contact_distance": "0.2",
    "perimeter_speed": "45",
    "external_perimeter_speed": "25",
    "small_perimeter_speed": "25",
    "infill_speed": "80",
    "solid_infill_speed": "80",
    "top_solid_infill_speed": "40",
    "support_material_speed": "50",
    "support_material_interface_speed": "80%",
    "bridge_speed": "30",
    "gap_fill_speed": "40",
    "travel_speed": "180",
    "first_layer_speed": "20",
    "retract_speed": "35",
    "retract_before_travel": "1.5",
    "cooling": "1",
    "slowdown_below_layer_time": "15",
    "disable_fan_first_layers": "1",
    "gcode_comments": "0",
    # The names of what is printed stand in the G-code as comments, for people and for us.
    "gcode_label_objects": "1",
    "use_relative_e_distances": "1",
    # Marlin wants the extruder reset at each layer where its distances are relative.
    "before_layer_gcode": "G92 E0",
    "use_firmware_retraction": "0",
    "use_volumetric_e": "0",
    "remaining_times": "1",
    "extrusion_multiplier": "1",
    "thumbnails": "",
    "post_process": "",
}
"""Settings that no profile changes."""

WIDTHS = (
    *("", "first_layer_", "perimeter_", "external_perimeter_"),
    *("infill_", "solid_infill_", "top_infill_", "support_material_"),
)
"""Types of lines of which the width is set."""

START = (
    "M140 S[first_layer_bed_temperature]",
    "M104 S[first_layer_temperature]",
    "G90",
    "G28",
    "M190 S[first_layer_bed_temperature]",
    "M109 S[first_layer_temperature]",
)
END = ("M104 S0", "M140 S0", "M107", "G91", "G1 Z5 F600", "G90", "G28 X0", "M84")


def settings(profile: Profile, *, brim_mm: float = 0.0, skirt: bool = True) -> str:
    """Return the configuration file of a profile, the same bytes for the same profile.

    Args:
        profile: Printer, material and settings.
        brim_mm: Width of the brim, 0 for none.
        skirt: Whether a line is drawn around what is printed, to prime the nozzle.
    """
    chosen = STEADY | _chosen(profile)
    chosen |= {
        "brim_type": "outer_only" if brim_mm else "no_brim",
        "brim_width": f"{brim_mm:g}",
        "skirts": "1" if skirt else "0",
        "skirt_distance": f"{SKIRT_MM + brim_mm:g}",
        "skirt_height": "1",
    }
    return "".join(f"{key} = {value}\n" for key, value in sorted(chosen.items()))


def _chosen(profile: Profile) -> dict[str, str]:
    printer, material = profile.printer, profile.material
    width, depth, height = printer.bed_mm
    layer, line = f"{profile.layer_mm:g}", f"{profile.line_mm:g}"
    start = (*START, printer.level, "G92 E0") if printer.level else (*START, "G92 E0")
    return {
        "bed_shape": f"0x0,{width:g}x0,{width:g}x{depth:g},0x{depth:g}",
        "max_print_height": f"{height:g}",
        "nozzle_diameter": f"{printer.nozzle_mm:g}",
        "filament_diameter": f"{printer.filament_mm:g}",
        "retract_length": f"{printer.retract_mm:g}",
        "filament_type": material.name.upper(),
        # The slicer's density is in g/cm3.
        "filament_density": f"{material.density / 1000.0:g}",
        "first_layer_temperature": str(material.nozzle_c),
        "temperature": str(material.nozzle_c),
        "first_layer_bed_temperature": str(material.bed_c),
        "bed_temperature": str(material.bed_c),
        "min_fan_speed": str(material.fan_percent),
        "max_fan_speed": str(material.fan_percent),
        "bridge_fan_speed": str(max(material.fan_percent, 30)),
        "layer_height": layer,
        "first_layer_height": layer,
        **{f"{each}extrusion_width": line for each in WIDTHS},
        "perimeters": str(profile.walls),
        "top_solid_layers": str(profile.solid_layers[0]),
        "bottom_solid_layers": str(profile.solid_layers[1]),
        "fill_density": f"{100.0 * profile.infill:g}%",
        # Only straight lines fill all of the inside; the slicer refuses others at 100 %.
        "fill_pattern": "rectilinear" if profile.infill == 1.0 else "cubic",
        # The slicer counts from the bed, we from upright.
        "support_material_threshold": f"{max(1.0, 90.0 - profile.overhang_deg):.0f}",
        "start_gcode": "\\n".join(start),
        "end_gcode": "\\n".join(END),
    }
