#!/usr/bin/perl
# The points of a job while they move: told to who asks, decimated, once a second; and nothing else changes by it.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Time::HiRes qw(time);
use Vt;

my $daemon = Vt->start('drain-timeout' => 0, jobs => 2);
my $cloud = sphere_ply(3000);
my $long = 'points=3000&iterations=10000&delta=0&polish=0';
my $id = $daemon->submit($long, $cloud);

sub stream { return $daemon->events(@_) }
sub data { return json($_[0]{data}) }
sub next_preview { my ($stream) = @_; while (my $event = $stream->next_event) { return $event if $event->{event} eq 'preview' } }
sub local_of { return $_[0] =~ s/^\Q$daemon->{url}\E//r }

# The positions in a binary PLY, as rows.
sub positions {
    my ($bytes) = @_;
    my ($n, $type) = $bytes =~ /element vertex (\d+)\nproperty (float|double) x\n/ or return;
    my @numbers = unpack(($type eq 'float' ? 'f<' : 'd<') . 3 * $n, $bytes =~ s/\A.*?end_header\n//sr);
    return map { [@numbers[3 * $_ .. 3 * $_ + 2]] } 0 .. $n - 1;
}

my $plain = stream("/v1/jobs/$id/events");
my @events = map { $plain->next_event } 1 .. 8;
$plain->close;
is scalar(grep { $_->{event} eq 'preview' } @events), 0, 'who does not ask is told of no preview';
is_problem $daemon->get("/v1/jobs/$id/preview"), 404, 'result-not-available', 'and there is none';

my $began = time;
my $stream = stream("/v1/jobs/$id/events?preview=1000");
my $first = next_preview($stream);
my $told = data($first);
is_deeply [sort keys %$told], [qw(href iteration jobID points polish)], 'a preview says where it is and what of';
is $told->{jobID}, $id, 'its job';
is $told->{points}, 1000, 'as many points as were asked for';
is $first->{id}, undef, 'no id, as nobody comes back to it';
my $path = local_of($told->{href});
is $path, "/v1/jobs/$id/preview?points=1000", 'where it leads to';
my $seen = $daemon->get($path);
is $seen->{headers}{'content-type'}, 'application/ply', 'it is a PLY that any program reads';
my @points = positions($seen->{content});
is scalar @points, 1000, 'of so many points';
my @radii = sort { $a <=> $b } map { sqrt($_->[0]**2 + $_->[1]**2 + $_->[2]**2) } @points;
ok $radii[0] > 0.9 && $radii[-1] < 1.1, 'on the surface of the input' or diag "@radii[0, -1]";
my %places = map { join(' ', @$_) => 1 } @points;
cmp_ok scalar keys %places, '>', 990, 'in places of their own';
my $tag = $seen->{headers}{etag};
ok wait_until(
    sub {
        my $now = $daemon->get($path)->{headers}{etag};
        return $daemon->get($path, headers => { 'If-None-Match' => $now })->{status} == 304;
    }), 'what has not moved since is not sent again';
is scalar(positions($daemon->get("/v1/jobs/$id/preview?points=10")->{content})), 10, 'or fewer of them';
is scalar(positions($daemon->get("/v1/jobs/$id/preview")->{content})), 3000, 'or all';
my $second = data(next_preview($stream));
cmp_ok time - $began, '>=', 0.95, 'the next one comes a second later';
cmp_ok $second->{iteration}, '>', $told->{iteration}, 'after more iterations';
my $moved = $daemon->get($path);
isnt $moved->{headers}{etag}, $tag, 'under a tag of its own';
isnt $moved->{content}, $seen->{content}, 'with other positions';

# Two jobs in one stream, as lines; then nobody looks.
my $other = $daemon->submit($long, $cloud);
my $both = stream("/v1/events?jobs=$id,$other&preview=5", headers => { Accept => 'application/x-ndjson' });
my %of;
while (keys %of < 2) {
    last unless $both->more;
    $both->unchunk;
    while ($both->{text} =~ s/\A(.*)\n//) {
        my $line = length $1 ? json($1) : {};
        $of{ $line->{data}{jobID} } = $line if ($line->{event} // '') eq 'preview';
    }
}
is_deeply { map { $_ => $of{$_}{data}{points} } keys %of }, { $id => 5, $other => 5 }, 'one stream tells those of each job';
is_deeply [grep { exists $of{$_}{id} } keys %of], [], 'without an id';
$_->close for $both, $stream;

# Nothing is shown while the job goes on for longer than it takes from one preview to the next.
sub ran { return json($daemon->get("/v1/jobs/$id"))->{voronoid}{metrics}{seconds} }
ok wait_until(
    sub {
        my ($before, $since) = ($daemon->get($path)->{headers}{etag}, ran());
        wait_until(sub { ran() > $since + 2 });
        return $daemon->get($path)->{headers}{etag} eq $before;
    }), 'once nobody looks none is made';
is_problem $daemon->get("/v1/jobs/$id/preview?points=$_"), 400, 'invalid-query-parameter-value', "points=$_ is refused"
    for qw(0 50001 many -1), '';
for my $where ("/v1/jobs/$id/events?preview=50001", "/v1/events?jobs=$id&preview=0") {
    my $refused = $daemon->get($where);
    is_problem $refused, 400, 'invalid-query-parameter-value', "$where is refused";
    like json($refused)->{detail}, qr/^preview is "\d+", want a whole number from 1 to 50000$/, 'with what is wanted';
}
$daemon->request('DELETE', "/v1/jobs/$_") for $id, $other;
is_problem $daemon->get($path), 404, 'result-not-available', 'a job that is over shows nothing';

# Far from zero, where float32 has steps of 6 cm: positions are those of the input's frame.
my @corner = (637000.25, 4849000.5, 120);
my $far = "ply\nformat binary_little_endian 1.0\nelement vertex 900\n" . join('', map { "property double $_\n" } qw(x y z)) . "end_header\n";
for my $i (0 .. 899) { $far .= pack 'd<3', $corner[0] + ($i % 30) * 0.01, $corner[1] + int($i / 30) * 0.01, $corner[2] }
my $utm = $daemon->submit('points=800&iterations=10000&delta=0&polish=0', $far);
my $watch = stream("/v1/jobs/$utm/events?preview=800");
next_preview($watch);
my @far = positions($daemon->get("/v1/jobs/$utm/preview")->{content});
is scalar @far, 800, 'a cloud far from zero has a preview';
is scalar(grep { $_->[0] < $corner[0] - 0.02 || $_->[0] > $corner[0] + 0.31 || $_->[1] < $corner[1] - 0.02 || $_->[1] > $corner[1] + 0.31 } @far), 0,
    'in its own frame';
my %columns = map { sprintf('%.4f', $_->[0]) => 1 } @far;
cmp_ok scalar keys %columns, '>', 100, 'and not in steps';
$watch->close;
$daemon->request('DELETE', "/v1/jobs/$utm");

# The bytes of a result are the same, whoever looks; each way that moves points shows them.
for my $how ('iterations=8&polish=20', 'method=kmeans&iterations=5', 'metric=lp&iterations=3') {
    my $bytes = $daemon->post("/v1/resample?points=500&$how", $cloud)->{content};
    my $blocker = $daemon->submit($long, $cloud) . ',' . $daemon->submit($long, $cloud); # so that the job waits until somebody looks
    my $watched = $daemon->submit("points=500&$how", $cloud);
    my $looking = stream("/v1/jobs/$watched/events?preview=50000");
    $looking->next_event;
    $daemon->request('DELETE', "/v1/jobs/$_") for split /,/, $blocker;
    my @told = grep { $_->{event} eq 'preview' } $looking->all;
    cmp_ok scalar @told, '>=', 1, "$how: a preview was told";
    is $daemon->get("/v1/jobs/$watched/results/cloud")->{content}, $bytes, 'and the result has the same bytes';
}
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
