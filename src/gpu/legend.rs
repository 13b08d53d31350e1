//! Draws the legend into a picture: the colour bar with the values at its ends. The letters are a built-in
//! bitmap font, so that pictures need no font files.

use super::renderer::Picture;
use super::scene::{FloorColours, SceneOptions};
use crate::palette::{ColourMap, TABLE_LEN, Theme, to_bytes};

/// Heights of a picture per dot of its legend, pixels: text of 1 in 40 can be read where the picture fills a
/// page or a slide.
const HEIGHT_PER_DOT: u32 = 300;
/// Smallest side of a dot in pictures that are large enough for it, pixels.
const MIN_DOT: u32 = 2;
/// Greatest share of the width of the picture that a legend of larger dots takes: it hides what is behind it.
const MAX_SHARE: f64 = 0.45;
/// Width of the bar, and height of it, dots: the longest title fits above it.
const BAR: [u32; 2] = [120, 8];
/// Distance of text and bar from the edges of the picture, and from those of the plate, dots.
const INSET: u32 = 12;
const PLATE_MARGIN: u32 = 6;
/// Height from the title to the lower edge of the picture, dots.
const LEGEND_HEIGHT: u32 = 44;

/// Bitmap font of 5 × 7 dots: one number per row, the highest of five bits leftmost.
const LETTERS: &[(char, [u8; 7])] = &[
    ('0', [14, 17, 19, 21, 25, 17, 14]),
    ('1', [4, 12, 4, 4, 4, 4, 14]),
    ('2', [14, 17, 1, 2, 4, 8, 31]),
    ('3', [31, 2, 4, 2, 1, 17, 14]),
    ('4', [2, 6, 10, 18, 31, 2, 2]),
    ('5', [31, 16, 30, 1, 1, 17, 14]),
    ('6', [6, 8, 16, 30, 17, 17, 14]),
    ('7', [31, 1, 2, 4, 8, 8, 8]),
    ('8', [14, 17, 17, 14, 17, 17, 14]),
    ('9', [14, 17, 17, 15, 1, 2, 12]),
    ('.', [0, 0, 0, 0, 0, 12, 12]),
    ('-', [0, 0, 0, 31, 0, 0, 0]),
    ('+', [0, 4, 4, 31, 4, 4, 0]),
    ('m', [0, 0, 26, 21, 21, 21, 21]),
    ('o', [0, 0, 14, 17, 17, 17, 14]),
    ('n', [0, 0, 22, 25, 17, 17, 17]),
    ('h', [16, 16, 22, 25, 17, 17, 17]),
    ('u', [0, 0, 17, 17, 17, 19, 13]),
    ('b', [16, 16, 22, 25, 17, 17, 30]),
    ('t', [8, 8, 28, 8, 8, 9, 6]),
    ('c', [0, 0, 14, 16, 16, 17, 14]),
    ('k', [16, 16, 18, 20, 24, 20, 18]),
    ('s', [0, 0, 14, 16, 14, 1, 30]),
    ('e', [0, 0, 14, 17, 31, 16, 14]),
    ('f', [6, 9, 8, 28, 8, 8, 8]),
    ('r', [0, 0, 22, 25, 16, 16, 16]),
    ('a', [0, 0, 14, 1, 15, 17, 15]),
    ('d', [1, 1, 13, 19, 17, 17, 15]),
    ('p', [0, 0, 30, 17, 30, 16, 16]),
    ('i', [4, 0, 12, 4, 4, 4, 14]),
    ('l', [12, 4, 4, 4, 4, 4, 14]),
    ('w', [0, 0, 17, 17, 21, 21, 10]),
];
/// Width of a letter with the gap after it, dots.
const ADVANCE: u32 = 6;

/// Draws the legend of a picture made with `options`, if the floor is coloured by value.
pub fn add_legend(picture: &mut Picture, options: &SceneOptions) {
    let (map, title) = match options.show_floor_colours {
        FloorColours::Residual if options.show_solid => (options.map, "distance to part"),
        FloorColours::Residual => (options.map, "stock on hub"),
        FloorColours::Interference => (ColourMap::Contact, "contact of the core"),
        FloorColours::Values if options.map == ColourMap::Difference => (options.map, "after minus before"),
        FloorColours::Walls => (options.map, "stock on walls"),
        FloorColours::Values | FloorColours::Plain => return,
    };
    draw_legend(picture, map, options.range_mm, title, options.theme);
}

/// Draws the legend into the lower left corner of a picture, on a plate of its own: behind it the picture may
/// be transparent, or as dark as its text. `title` stands above the bar (letters that [`LETTERS`] lacks stay
/// blank), the ends of `range` in mm below it. It scales with the picture.
fn draw_legend(picture: &mut Picture, map: ColourMap, range: (f32, f32), title: &str, theme: Theme) {
    let fits = |dot: &u32| {
        let share = if *dot > 1 { MAX_SHARE } else { 1.0 };
        f64::from((BAR[0] + 2 * INSET) * dot) <= share * f64::from(picture.width)
            && picture.height >= (LEGEND_HEIGHT + PLATE_MARGIN) * dot
    };
    let wanted = picture.height.div_ceil(HEIGHT_PER_DOT).max(MIN_DOT);
    let Some(dot) = (1..=wanted).rev().find(fits) else { return };
    let (left, bar_width, bar_height) = (INSET * dot, BAR[0] * dot, BAR[1] * dot);
    let top = picture.height - LEGEND_HEIGHT * dot;
    let ink = match theme {
        Theme::Light => [30, 34, 38],
        Theme::Dark => [232, 235, 238],
    };
    let mut pen = Pen { picture, dot, ink };
    let margin = PLATE_MARGIN * dot;
    let plate_height = (11 + BAR[1] + 3 + 7) * dot + 2 * margin;
    let plate = to_bytes(theme.greys().background_top);
    pen.fill(left - margin, top - margin, bar_width + 2 * margin, plate_height, plate);
    pen.text(left, top, title);
    let table = map.table();
    for x in 0..bar_width {
        let colour = table[(x as usize * (TABLE_LEN - 1)) / (bar_width as usize - 1).max(1)];
        pen.fill(left + x, top + 11 * dot, 1, bar_height, colour);
    }
    let below = top + 11 * dot + bar_height + 3 * dot;
    let digits = if range.1 < 0.1 { 4 } else { 2 };
    pen.text(left, below, &format!("{:.digits$}", range.0));
    let high = format!("{:.digits$}+ mm", range.1);
    let width = high.chars().count() as u32 * ADVANCE * dot;
    pen.text((left + bar_width).saturating_sub(width), below, &high);
}

struct Pen<'a> {
    picture: &'a mut Picture,
    /// Side of a dot, pixels.
    dot: u32,
    ink: [u8; 3],
}

impl Pen<'_> {
    fn text(&mut self, left: u32, top: u32, text: &str) {
        for (k, letter) in text.chars().enumerate() {
            let Some((_, rows)) = LETTERS.iter().find(|(known, _)| *known == letter) else { continue };
            for (y, row) in rows.iter().enumerate() {
                for x in (0..5u32).filter(|x| row & (16 >> x) != 0) {
                    let at = left + (k as u32 * ADVANCE + x) * self.dot;
                    self.fill(at, top + y as u32 * self.dot, self.dot, self.dot, self.ink);
                }
            }
        }
    }

    fn fill(&mut self, left: u32, top: u32, width: u32, height: u32, colour: [u8; 3]) {
        let (right, bottom) =
            ((left + width).min(self.picture.width), (top + height).min(self.picture.height));
        for y in top..bottom {
            for x in left..right {
                let at = 4 * (y as usize * self.picture.width as usize + x as usize);
                if let Some(pixel) = self.picture.rgba.get_mut(at..at + 4) {
                    pixel[..3].copy_from_slice(&colour);
                    pixel[3] = 255;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_shows_the_ends_of_the_table_and_small_pictures_have_none() {
        let blank =
            |width: u32, height: u32| Picture { width, height, rgba: vec![0; (4 * width * height) as usize] };
        let mut picture = blank(640, 360);
        draw_legend(&mut picture, ColourMap::Cividis, (0.5, 4.0), "stock", Theme::Light);
        let pixel = |x: u32, y: u32| picture.rgba[(4 * (y * 640 + x)) as usize..][..4].to_vec();
        let y = 360 - 2 * 44 + 2 * 11 + 3;
        let table = ColourMap::Cividis.table();
        assert_eq!(pixel(24, y), [&table[0][..], &[255]].concat());
        assert_eq!(pixel(24 + 239, y), [&table[255][..], &[255]].concat());
        assert!(picture.rgba.chunks(4).any(|p| p == [30, 34, 38, 255]), "letters");
        // Of a transparent picture the plate is what is behind the letters.
        let plate = [&to_bytes(Theme::Light.greys().background_top)[..], &[255]].concat();
        for (x, y) in [(14, y), (24 + 250, y), (40, 360 - 2 * 44 - 8), (40, 360 - 2 * 44 + 2 * 29 + 8)] {
            assert_eq!(pixel(x, y), plate, "at {x}, {y}");
        }
        assert_eq!(pixel(4, y), [0; 4], "and no more than that");
        let mut narrow = blank(160, 360);
        draw_legend(&mut narrow, ColourMap::Cividis, (0.5, 4.0), "stock", Theme::Light);
        assert!(narrow.rgba.iter().any(|&byte| byte > 0), "smaller where it would not fit");
        let mut tiny = blank(60, 30);
        draw_legend(&mut tiny, ColourMap::Cividis, (0.0, 1.0), "stock", Theme::Dark);
        assert!(tiny.rgba.iter().all(|&byte| byte == 0));
    }

    #[test]
    fn every_letter_of_the_titles_is_there() {
        for title in
            ["stock on hub", "contact of the core", "after minus before", "stock on walls", "0.50 4.00+ mm-"]
        {
            for letter in title.chars().filter(|c| *c != ' ') {
                assert!(LETTERS.iter().any(|(known, _)| *known == letter), "{letter:?} of {title:?}");
            }
        }
    }
}
