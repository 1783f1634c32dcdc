use super::*;

#[test]
fn places_are_mirrored_sorted_and_kept_once() {
    let pattern = Pattern::new(4, [(2, 0), (0, 2), (3, 0), (1, 1)].into_iter());
    assert_eq!(pattern.column(0), [0, 2, 3]);
    assert_eq!(pattern.column(1), [1]);
    assert_eq!(pattern.column(2), [0, 2]);
    assert_eq!(pattern.column(3), [0, 3]);
    assert_eq!(pattern.find(3, 0), Some(2));
    assert_eq!(pattern.find(3, 1), None);
    assert_eq!(pattern.len(), 8);
}

#[test]
fn a_permuted_pattern_knows_where_its_places_come_from() {
    let pattern = Pattern::new(4, [(2, 0), (3, 0), (1, 3)].into_iter());
    let order = [3, 1, 0, 2];
    let (moved, origin) = pattern.permuted(&order);
    for j in 0..4 {
        for (at, &i) in (moved.starts[j]..).zip(moved.column(j)) {
            assert_eq!(pattern.find(order[i as usize], order[j]), Some(origin[at]));
        }
    }
    assert_eq!(moved.len(), pattern.len());
}

#[test]
fn a_part_of_a_pattern_keeps_mirror_images_and_the_diagonal() {
    let pattern = Pattern::new(4, [(2, 0), (3, 0), (1, 3)].into_iter());
    let wanted = pattern.find(3, 0).unwrap();
    let (part, origin) = pattern.kept(|at| at == wanted);
    assert_eq!(part, Pattern::new(4, [(3, 0)].into_iter()));
    for j in 0..4 {
        for (at, &i) in (part.starts[j]..).zip(part.column(j)) {
            assert_eq!(pattern.find(i as usize, j), Some(origin[at]));
        }
    }
}
