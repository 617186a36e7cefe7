//! News until somebody takes them; if nobody does, the oldest make room.

use heapless::Deque;

/// At most `N` of them.
#[derive(Clone, Debug)]
pub(crate) struct Untold<T, const N: usize>(Deque<T, N>);

impl<T, const N: usize> Untold<T, N> {
    pub(crate) const fn new() -> Self {
        Self(Deque::new())
    }

    pub(crate) fn push(&mut self, news: T) {
        if self.0.is_full() {
            self.0.pop_front();
        }
        let _there_is_room = self.0.push_back(news);
    }

    /// The oldest.
    pub(crate) fn pop(&mut self) -> Option<T> {
        self.0.pop_front()
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}

impl<T, const N: usize> Extend<T> for Untold<T, N> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, news: I) {
        news.into_iter().for_each(|news| self.push(news));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_make_room() {
        let mut untold = Untold::<u8, 2>::new();
        for news in 1..=3 {
            untold.push(news);
        }
        assert_eq!([untold.pop(), untold.pop(), untold.pop()], [Some(2), Some(3), None]);
    }
}
