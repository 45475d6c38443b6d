#!/usr/bin/perl
# A page that is loaded anew in the middle of a job: the curve so far, what follows it, and the input to compare with.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start('drain-timeout' => 0);
my $cloud = sphere_ply(1500);
my $id = $daemon->submit('points=1500&iterations=10000&delta=0&polish=0', $cloud);

sub trace { return json($daemon->get("/v1/jobs/$id/trace")) }
sub progress { return map { json($_->{data}) } grep { $_->{event} eq 'progress' } @_ }

ok wait_until(sub { @{ trace()->{records} } >= 5 }), 'a job has done some iterations';
for my $how ("/v1/jobs/$id/events", "/v1/events?jobs=$id") {
    my $trace = trace();
    my @curve = map { $_->{iteration} } @{ $trace->{records} };
    is_deeply \@curve, [0 .. $#curve], 'its trace has every iteration so far';
    my $stream = $daemon->events($how . ($how =~ /\?/ ? '&' : '?') . "lastEventId=$trace->{lastEventId}");
    my ($attempt, $number) = split /\./, $trace->{lastEventId};
    my $event = $stream->next_event;
    is $event->{id}, "$attempt." . ($number + 1), "$how goes on with the event behind it";
    is +(progress($event))[0]{iteration}, @curve, 'that of the next iteration: none is missing, none comes twice';
    $stream->close;
    my $whole = $daemon->events($how . ($how =~ /\?/ ? '&' : '?') . 'lastEventId=0.0');
    my @events;
    push @events, $whole->next_event until (progress(@events))[5];
    is_deeply [map { $_->{iteration} } (progress(@events))[0 .. 5]], [0 .. 5], 'from 0.0 on it has all of them, too';
    $whole->close;
}
my $input = $daemon->get("/v1/jobs/$id/input");
is $input->{status}, 200, 'the input is there while the job runs';
is $input->{content}, $cloud, 'as it came';
is $daemon->post("/v1/jobs/$id/stop", '')->{status}, 202, 'the job is stopped';
is $daemon->finish($id)->{status}, 'successful', 'and keeps the best so far';
my $over = trace();
my @stored = map { $_->{iteration} } @{ $over->{records} };
cmp_ok scalar @stored, '>', 5, 'a job that is over has its trace';
is $daemon->get("/v1/jobs/$id/input")->{content}, $cloud, 'and its input';
my $last = $over->{lastEventId};
is $daemon->get("/v1/jobs/$id/events?lastEventId=$last")->{status}, 204, 'whose last event is its end';
like $daemon->get("/v1/jobs/$id/trace", headers => { Accept => 'text/csv' })->{content}, qr/^iteration,.*\n0,/, 'a table has the records alone';
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
