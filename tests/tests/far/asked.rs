//! Queries and drawings of a world of every kind of shape at a corner of eight sectors, here and far away.

use cellstep::debug::Color;
use cellstep::math::Vec3;
use cellstep::{
    ClosestPoint, DebugDraw, DebugLayers, DebugOptions, Found, Hit, Overlap, Position, Probe, Queries,
    QueryFilter, QueryShape, Ray, Region, ShapeCast,
};
use cellstep_tests::executors::Random;
use cellstep_tests::mixed::{Draw, mixed_world};
use cellstep_tests::sectors::{SHIFTS, Shift, move_bodies, moved};
use cellstep_tests::worlds::{OwnedWorld, run};

/// From the middle of a sector to a corner of eight of them.
const CORNER: Vec3 = Vec3::new(32.0, 32.0, 32.0);

/// What is asked, with the places moved.
#[derive(Clone, Copy, Debug)]
enum Question {
    Ray(Ray),
    Cast(ShapeCast),
    Overlap(Region),
    Closest(Probe),
}

/// What is found, with the places moved.
#[derive(Debug, PartialEq)]
enum Answer {
    Hits(Option<Hit>, Vec<Hit>, Found),
    Overlaps(Option<Overlap>, Vec<Overlap>, Found),
    Points(Option<ClosestPoint>, Vec<ClosestPoint>, Found),
}

fn question(random: &mut Random) -> Question {
    let place = |random: &mut Random| Position::at(CORNER).plus(random.vector(12.0));
    let shape = |random: &mut Random| QueryShape {
        geometry: random.solid(1.0),
        position: place(random),
        rotation: random.rotation(),
    };
    // Some ways lead through several sectors.
    let way = |random: &mut Random| {
        let length = [15.0, 15.0, 300.0][random.below(3) as usize];
        random.vector(length)
    };
    match random.below(6) {
        0 | 1 => Question::Ray(Ray { origin: place(random), translation: way(random) }),
        2 => Question::Cast(ShapeCast { shape: shape(random), translation: way(random) }),
        3 => Question::Overlap(Region::Shape(shape(random))),
        4 => {
            let half_extents = Vec3::splat(random.between(0.1, 4.0));
            Question::Overlap(Region::Box { center: place(random), half_extents })
        }
        _ => Question::Closest(Probe { position: place(random), max_distance: random.between(0.1, 100.0) }),
    }
}

impl Question {
    fn moved(self, by: Shift) -> Self {
        let shape = |shape: QueryShape| QueryShape { position: moved(shape.position, by), ..shape };
        match self {
            Self::Ray(ray) => Self::Ray(Ray { origin: moved(ray.origin, by), ..ray }),
            Self::Cast(cast) => Self::Cast(ShapeCast { shape: shape(cast.shape), ..cast }),
            Self::Overlap(Region::Point(place)) => Self::Overlap(Region::Point(moved(place, by))),
            Self::Overlap(Region::Box { center, half_extents }) => {
                Self::Overlap(Region::Box { center: moved(center, by), half_extents })
            }
            Self::Overlap(Region::Shape(own)) => Self::Overlap(Region::Shape(shape(own))),
            Self::Closest(probe) => Self::Closest(Probe { position: moved(probe.position, by), ..probe }),
        }
    }

    /// The first that is found, and all.
    fn ask(self, queries: &Queries<'_>, filter: &QueryFilter) -> Answer {
        let (mut hits, mut overlaps) = (vec![Hit::default(); 60], vec![Overlap::default(); 60]);
        let mut points = vec![ClosestPoint::default(); 60];
        match self {
            Self::Ray(ray) => {
                let first = queries.cast_ray(&ray, filter).expect("in range");
                let found = queries.cast_ray_all(&ray, filter, &mut hits).expect("in range");
                Answer::Hits(first, hits, found)
            }
            Self::Cast(cast) => {
                let first = queries.cast_shape(&cast, filter).expect("in range");
                let found = queries.cast_shape_all(&cast, filter, &mut hits).expect("in range");
                Answer::Hits(first, hits, found)
            }
            Self::Overlap(region) => {
                let first = queries.overlap(&region, filter).expect("in range");
                let found = queries.overlap_all(&region, filter, &mut overlaps).expect("in range");
                Answer::Overlaps(first, overlaps, found)
            }
            Self::Closest(probe) => {
                let first = queries.closest_point(&probe, filter).expect("in range");
                let found = queries.closest_point_all(&probe, filter, &mut points).expect("in range");
                Answer::Points(first, points, found)
            }
        }
    }
}

impl Answer {
    fn moved(mut self, by: Shift) -> Self {
        match &mut self {
            Self::Hits(first, all, found) => {
                let told = all.iter_mut().take(found.count);
                first.iter_mut().chain(told).for_each(|hit| hit.point = moved(hit.point, by));
            }
            Self::Points(first, all, found) => {
                let told = all.iter_mut().take(found.count);
                first.iter_mut().chain(told).for_each(|point| point.point = moved(point.point, by));
            }
            Self::Overlaps(..) => {}
        }
        self
    }

    fn is_empty(&self) -> bool {
        matches!(self, Self::Hits(None, ..) | Self::Overlaps(None, ..) | Self::Points(None, ..))
    }
}

fn world(by: Shift) -> OwnedWorld {
    let mut world = mixed_world(7);
    move_bodies(&mut world, CORNER, by);
    run(&mut world, 3);
    world
}

#[test]
fn queries_across_borders_find_the_same_everywhere() {
    let mut here = world([0; 3]);
    for (seed, by) in SHIFTS.into_iter().enumerate() {
        let (mut there, mut random) = (world(by), Random::new(seed as u64));
        let (here, there) = (here.queries(), there.queries());
        let mut met = 0;
        for index in 0..600 {
            let question = question(&mut random);
            let own = question.ask(&here, &QueryFilter::ALL);
            met += usize::from(!own.is_empty());
            let far = question.moved(by).ask(&there, &QueryFilter::ALL);
            assert_eq!(own.moved(by), far, "{by:?}, question {index}: {question:?}");
        }
        assert!(met > 300, "{met} of 600 found something");
    }
}

#[derive(Debug, Default, PartialEq)]
struct Drawing(Vec<(Vec3, Vec3, Color)>, Vec<(Vec3, Color)>, Vec<(Vec3, String, Color)>);

impl DebugDraw for Drawing {
    fn line(&mut self, from: Vec3, to: Vec3, color: Color) {
        self.0.push((from, to, color));
    }

    fn point(&mut self, at: Vec3, color: Color) {
        self.1.push((at, color));
    }

    fn text(&mut self, at: Vec3, text: &str, color: Color) {
        self.2.push((at, text.to_string(), color));
    }
}

#[test]
fn far_worlds_are_drawn_as_near_ones() {
    let drawn = |by: Shift| {
        let (mut drawing, origin) = (Drawing::default(), moved(Position::at(CORNER), by));
        let options = DebugOptions { layers: DebugLayers::ALL, ..DebugOptions::default() };
        world(by).debug_draw(origin, &options, &mut drawing);
        drawing
    };
    let here = drawn([0; 3]);
    assert!(here.0.len() > 1000 && !here.1.is_empty(), "{} lines", here.0.len());
    for by in SHIFTS {
        assert!(drawn(by) == here, "{by:?}");
    }
}
