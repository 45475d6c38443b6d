#!/usr/bin/perl
# Who crashes the daemon is found out, and nobody else is blamed: what ran in a crash is run again with nothing beside it.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin, "$FindBin::Bin/../cli", "$FindBin::Bin/../support";
use Toy;
use JSON::PP;
use Test::More;
use Time::HiRes qw(sleep);
use Vt;

my $cloud = cloud_of(grid(5, 0, 0, 0));
my $good = '/v1/census?parts=3&pause=0.01';

# A daemon on the directory of an earlier one that has ended by itself or is ended now.
sub again {
    my ($before) = @_;
    Vt::reap(delete $before->{pid}, 20) if $before->{pid};
    return eval { Vt->start(dir => $before->{dir}, jobs => 4) };
}

sub submit {
    my ($daemon, $path) = @_;
    my $answer = eval { $daemon->post($path, $cloud, Prefer => 'respond-async') } // return undef;
    return $answer->{status} == 201 ? json($answer)->{jobID} : undef;
}

# The status and message of a job; undef where nobody answers.
sub ended {
    my ($daemon, $id) = @_;
    my $info = eval { json($daemon->get("/v1/jobs/$id")) } // return undef;
    return "$info->{status}: $info->{message}";
}

for my $venom (qw(fault abort)) {
    subtest "a poison that ends by $venom among good jobs" => sub {
        # The first job is busy until all the others wait, so that the poison begins beside good ones.
        my $daemon = Vt->start(jobs => 4);
        my @good = map { submit($daemon, $good) } 1 .. 10;
        my $poison = submit($daemon, "/v1/poison?venom=$venom") // '';
        push @good, grep {defined} map { submit($daemon, $good) } 1 .. 10;
        ok $poison ne '', 'it is accepted';
        cmp_ok scalar(@good), '>=', 10, 'and so are they';

        my $crashes = 0;
        my $dir = $daemon->{dir};
        for (1 .. 8) {
            ok wait_until(sub { (ended($daemon, $poison) // '') =~ /^failed|^$/ }, 20), 'the daemon crashes or the poison is over';
            last if (ended($daemon, $poison) // '') =~ /^failed/;
            $crashes++;
            # One that starts with the poison in line may crash before it is asked anything.
            for (1 .. 5) {
                my $next = again($daemon);
                last if defined($next) && ($daemon = $next);
                $crashes++;
            }
        }
        cmp_ok $crashes, '>=', 2, 'the daemon crashes';
        cmp_ok $crashes, '<=', 3, 'three times at most: once beside others, twice alone';
        is ended($daemon, $poison), 'failed: the daemon crashed 2 times while it worked on this job alone', 'that is said of it';
        my @over = map { $daemon->finish($_)->{status} } @good;
        is_deeply [grep { $_ ne 'successful' } @over], [], 'all others succeed';
        is $daemon->stop, 0, 'the daemon ends with 0';
    };
}

subtest 'nobody is blamed for kill -9' => sub {
    my $daemon = Vt->start(jobs => 4);
    my @good = map { submit($daemon, '/v1/census?parts=20&pause=0.01') } 1 .. 6;
    my %attempts;
    for (1 .. 6) {
        sleep 0.1;
        kill 'KILL', $daemon->{pid};
        $daemon = again($daemon) // die 'it does not start';
    }
    for my $id (@good) {
        my $info = $daemon->finish($id);
        is $info->{status}, 'successful', "$id" or diag($info->{message});
        $attempts{$id} = $info->{voronoid}{attempt};
    }
    cmp_ok((sort { $b <=> $a } values %attempts)[0], '>=', 3, 'one was killed alone more often than a job may crash alone');
    is $daemon->stop, 0, 'the daemon ends with 0';
};
done_testing;
