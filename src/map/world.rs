//! A map in the world of another: the same image, with directions named as another program names them.
//!
//! It is the same map with other axes, exactly: a signed permutation times one is one. So a conversion that matches worlds costs
//! nothing and rounds nothing, and kernels know nothing of it.

use crate::geometry::world::World;
use crate::map::Map;
use glam::DMat3;

impl Map {
    /// The world that the map's directions live in: that of its convention, else [`World::OURS`].
    ///
    /// ```
    /// use spheremap::{Map, World};
    /// assert_eq!(Map::new("latlong:blender")?.world().up(), "+z");
    /// assert_eq!(Map::new("latlong")?.world(), World::OURS);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn world(&self) -> World {
        self.world
    }

    /// The same map, its directions said to be of another world: no axis of it changes.
    ///
    /// ```
    /// use spheremap::{Map, World};
    /// let map = Map::new("latlong")?.with_world(World::new("+y", "+z", true));
    /// assert!(map.world().left_handed());
    /// assert_eq!(map.axes(), Map::new("latlong")?.axes());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn with_world(&self, world: World) -> Map {
        Map {
            world,
            ..self.clone()
        }
    }

    /// This map with its directions in the world of another: what is up, ahead and to the right in the one is so in the other.
    /// The image is the same, texel by texel; only the names of directions change.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::glam::DVec3;
    ///
    /// let (blender, unity) = (Map::new("latlong:blender")?, Map::new("latlong:unity")?);
    /// let there = unity.in_world_of(&blender);
    /// assert_eq!(there.world(), blender.world());
    /// assert_eq!(there.encode_one(DVec3::Z), unity.encode_one(DVec3::Y)); // up
    /// assert_eq!(there.encode_one(DVec3::Y), unity.encode_one(DVec3::Z)); // ahead
    /// assert_eq!(there.encode_one(DVec3::X), unity.encode_one(DVec3::X)); // right
    /// assert_eq!(there.in_world_of(&unity), unity);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn in_world_of(&self, other: &Map) -> Map {
        if self.world == other.world {
            return self.clone();
        }
        let turn = other.world.to(self.world);
        let matrix = turn.matrix();
        // A pose between two signed permutations: its numbers move and change sign, and none is rounded.
        let pose = self.pose.map(|pose| {
            let numbers = (matrix.transpose() * pose * matrix).to_cols_array();
            DMat3::from_cols_array(&numbers.map(|x| x + 0.0))
        });
        Map {
            axes: self.axes.after(turn),
            pose,
            world: other.world,
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::axes::from_angles;
    use crate::map::conventions;
    use glam::DVec3;

    #[test]
    fn there_and_back_is_the_same_map() {
        let maps: Vec<Map> = conventions::all()
            .map(|row| Map::new(&format!("{}:{}", row.kind, row.name)).unwrap())
            .collect();
        let pose = from_angles(20.0, 30.0, 40.0);
        for a in &maps {
            let turned = a.turned(pose).unwrap();
            for b in &maps {
                let to = a.world().to(b.world());
                assert_eq!(to.inverse(), b.world().to(a.world()));
                assert_eq!(
                    to.mirrored(),
                    a.world().left_handed() != b.world().left_handed()
                );
                assert_eq!(a.in_world_of(b).in_world_of(a), *a);
                assert_eq!(turned.in_world_of(b).in_world_of(a), turned);
            }
        }
    }

    #[test]
    fn a_pose_moves_with_its_world() {
        let ours = Map::new("perspective").unwrap();
        let unreal = Map::new("cube:unreal").unwrap();
        let camera = ours.turned(from_angles(50.0, 20.0, 0.0)).unwrap();
        let there = camera.in_world_of(&unreal);
        let turn = unreal.world().to(World::OURS).matrix();
        for d in [DVec3::new(1.0, 0.4, 0.3), DVec3::new(1.0, -0.9, 0.1)] {
            let (here, there) = (camera.encode_one(turn * d), there.encode_one(d));
            match (here, there) {
                // Sums of the same three products, in another order.
                (Some((_, a)), Some((_, b))) => assert!(a.distance(b) < 1e-15),
                (a, b) => assert_eq!(a, b),
            }
        }
    }
}
